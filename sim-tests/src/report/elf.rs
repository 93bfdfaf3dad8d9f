//! Sections and symbols of the firmware's ELF file.
//!
//! Holds what the report needs beside the program itself: sizes, where static
//! memory ends, and names for addresses. A stripped file gives no names and no
//! error. Does not depend on the emulator.

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Symbol {
    /// As the linker has it.
    pub name: String,
    /// In bytes; data space begins at 0x80_0000.
    pub address: u32,
    /// In bytes; 0 for a mere label.
    pub len: u32,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Section {
    /// With its dot.
    pub name: String,
    /// In bytes.
    pub len: u32,
}

/// What an ELF file says about itself.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Elf {
    /// Sections in the file's order.
    pub sections: Vec<Section>,
    /// Symbols in the file's order.
    pub symbols: Vec<Symbol>,
}

impl Elf {
    /// Reads what is there of an ELF file that [`crate::firmware_image`] took.
    #[must_use]
    pub fn parse(bytes: &[u8]) -> Self {
        Self::parse_tables(bytes).unwrap_or_default()
    }

    /// Bytes of a section; 0 if there is none.
    #[must_use]
    pub fn section_len(&self, name: &str) -> u32 {
        self.sections.iter().find(|section| section.name == name).map_or(0, |section| section.len)
    }

    #[must_use]
    pub fn address_of(&self, name: &str) -> Option<u32> {
        self.symbols.iter().find(|symbol| symbol.name == name).map(|symbol| symbol.address)
    }

    /// The function that an address of the program lies in, as people write it.
    #[must_use]
    pub fn function_at(&self, address: u32) -> Option<String> {
        let holds = |symbol: &&Symbol| {
            symbol.len > 0 && (symbol.address..symbol.address + symbol.len).contains(&address)
        };
        let symbol = self.symbols.iter().find(holds)?;
        Some(format!("{:#}", rustc_demangle::demangle(&symbol.name)))
    }

    fn parse_tables(bytes: &[u8]) -> Option<Self> {
        const SYMBOL_TABLE: u32 = 2;
        let table_at = u32_at(bytes, 32)? as usize;
        let entry_len = usize::from(u16_at(bytes, 46)?);
        let count = usize::from(u16_at(bytes, 48)?);
        let names_index = usize::from(u16_at(bytes, 50)?);
        let field = |index: usize, field: usize| {
            u32_at(bytes, table_at.checked_add(index.checked_mul(entry_len)?)?.checked_add(4 * field)?)
        };
        // Name, type, ..., offset, size, link.
        let contents = |index: usize| {
            let at = field(index, 4)? as usize;
            bytes.get(at..at.checked_add(field(index, 5)? as usize)?)
        };
        let names = contents(names_index)?;

        let mut elf = Self::default();
        for index in 0..count {
            elf.sections.push(Section { name: text_at(names, field(index, 0)?)?, len: field(index, 5)? });
            if field(index, 1)? == SYMBOL_TABLE {
                let strings = contents(field(index, 6)? as usize)?;
                elf.symbols.extend(contents(index)?.chunks_exact(16).filter_map(|entry| {
                    Some(Symbol {
                        name: text_at(strings, u32_at(entry, 0)?)?,
                        address: u32_at(entry, 4)?,
                        len: u32_at(entry, 8)?,
                    })
                }));
            }
        }
        Some(elf)
    }
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

fn text_at(strings: &[u8], at: u32) -> Option<String> {
    let rest = strings.get(at as usize..)?;
    let len = rest.iter().position(|&byte| byte == 0)?;
    Some(String::from_utf8_lossy(&rest[..len]).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_cut_short_anywhere_gives_less_and_no_panic() {
        // A header that points at a section table behind its end.
        let mut bytes = [0_u8; 200];
        bytes[32..36].copy_from_slice(&60_u32.to_le_bytes());
        bytes[46..48].copy_from_slice(&40_u16.to_le_bytes());
        bytes[48..50].copy_from_slice(&3_u16.to_le_bytes());
        bytes[76..84].copy_from_slice(&[0xFF; 8]);

        for len in 0..bytes.len() {
            assert!(Elf::parse(&bytes[..len]).symbols.is_empty());
        }
    }

    #[test]
    fn an_address_is_found_in_the_function_that_holds_it() {
        let symbol = |name: &str, address, len| Symbol { name: name.into(), address, len };
        let elf =
            Elf { sections: vec![], symbols: vec![symbol("label", 8, 0), symbol("__vector_11", 4, 10)] };

        assert_eq!(elf.function_at(8).as_deref(), Some("__vector_11"));
        assert_eq!(elf.function_at(14), None);
    }
}
