//! Bytes to values.
//!
//! Holds what is left of a message. Past its end it reads zeros and reports that at
//! the end: only what steers the reading is judged on the way.

use super::WireError;
use serde::de::value::U8Deserializer;
use serde::de::{
    Deserialize, DeserializeSeed, Deserializer, EnumAccess, IntoDeserializer, SeqAccess, VariantAccess,
    Visitor,
};

/// The value that `bytes` hold, and nothing else.
///
/// # Errors
/// [`WireError`] if they are none, end early, or go on after it.
pub fn from_bytes<'de, T: Deserialize<'de>>(bytes: &'de [u8]) -> Result<T, WireError> {
    let mut reader = Reader { bytes, missing: false };
    let value = T::deserialize(&mut reader)?;
    if reader.missing || !reader.bytes.is_empty() { Err(WireError) } else { Ok(value) }
}

struct Reader<'de> {
    bytes: &'de [u8],
    /// Whether a byte was asked for that was not there.
    missing: bool,
}

impl<'de> Reader<'de> {
    #[inline(never)]
    fn take(&mut self) -> u8 {
        if let Some((&byte, rest)) = self.bytes.split_first() {
            self.bytes = rest;
            byte
        } else {
            self.missing = true;
            0
        }
    }

    /// A varint of at most `limit` bytes; what does not fit is told at the end.
    #[inline(never)]
    fn take_varint(&mut self, limit: u8) -> u32 {
        let (mut value, mut shift) = (0_u32, 0_u8);
        for _ in 0..limit {
            let byte = self.take();
            let part = u32::from(byte & 0x7F);
            value |= part << shift;
            if byte & 0x80 == 0 {
                // The last byte of the longest may hold only what is left of the type.
                if shift == 28 && part > 0x0F {
                    break;
                }
                return value;
            }
            shift += 7;
        }
        self.missing = true;
        0
    }

    #[inline(never)]
    fn take_u16(&mut self) -> u16 {
        let value = self.take_varint(3);
        if value > u32::from(u16::MAX) {
            self.missing = true;
        }
        value as u16
    }

    #[inline(never)]
    fn take_bytes(&mut self) -> &'de [u8] {
        let len = usize::from(self.take_u16());
        if let Some((bytes, rest)) = self.bytes.split_at_checked(len) {
            self.bytes = rest;
            bytes
        } else {
            self.missing = true;
            &[]
        }
    }
}

macro_rules! refused {
    ($($method:ident)*) => {$(
        fn $method<V: Visitor<'de>>(self, _: V) -> Result<V::Value, WireError> {
            Err(WireError)
        }
    )*};
}

impl<'de> Deserializer<'de> for &mut Reader<'de> {
    type Error = WireError;

    #[inline(always)]
    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, WireError> {
        match self.take() {
            0 => visitor.visit_bool(false),
            1 => visitor.visit_bool(true),
            _ => Err(WireError),
        }
    }

    #[inline(always)]
    fn deserialize_u8<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, WireError> {
        visitor.visit_u8(self.take())
    }

    #[inline(always)]
    fn deserialize_i8<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, WireError> {
        visitor.visit_i8(self.take() as i8)
    }

    #[inline(always)]
    fn deserialize_u16<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, WireError> {
        visitor.visit_u16(self.take_u16())
    }

    #[inline(always)]
    fn deserialize_i16<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, WireError> {
        let zigzag = self.take_u16();
        visitor.visit_i16((zigzag >> 1) as i16 ^ -((zigzag & 1) as i16))
    }

    #[inline(always)]
    fn deserialize_u32<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, WireError> {
        visitor.visit_u32(self.take_varint(5))
    }

    #[inline(always)]
    fn deserialize_i32<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, WireError> {
        let zigzag = self.take_varint(5);
        visitor.visit_i32((zigzag >> 1) as i32 ^ -((zigzag & 1) as i32))
    }

    #[inline(always)]
    fn deserialize_bytes<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, WireError> {
        visitor.visit_borrowed_bytes(self.take_bytes())
    }

    #[inline(always)]
    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, WireError> {
        match self.take() {
            0 => visitor.visit_none(),
            1 => visitor.visit_some(self),
            _ => Err(WireError),
        }
    }

    #[inline(always)]
    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, WireError> {
        visitor.visit_newtype_struct(self)
    }

    #[inline(always)]
    fn deserialize_tuple<V: Visitor<'de>>(self, len: usize, visitor: V) -> Result<V::Value, WireError> {
        visitor.visit_seq(Fields { reader: self, left: len })
    }

    #[inline(always)]
    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, WireError> {
        visitor.visit_seq(Fields { reader: self, left: fields.len() })
    }

    #[inline(always)]
    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, WireError> {
        visitor.visit_enum(self)
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: usize,
        _: V,
    ) -> Result<V::Value, WireError> {
        Err(WireError)
    }

    fn deserialize_unit_struct<V: Visitor<'de>>(self, _: &'static str, _: V) -> Result<V::Value, WireError> {
        Err(WireError)
    }

    refused! {
        deserialize_any deserialize_i64 deserialize_u64 deserialize_f32 deserialize_f64 deserialize_char
        deserialize_str deserialize_string deserialize_byte_buf deserialize_unit deserialize_seq
        deserialize_map deserialize_identifier deserialize_ignored_any
    }

    fn is_human_readable(&self) -> bool {
        false
    }
}

struct Fields<'r, 'de> {
    reader: &'r mut Reader<'de>,
    left: usize,
}

impl<'de> SeqAccess<'de> for Fields<'_, 'de> {
    type Error = WireError;

    #[inline(always)]
    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, WireError> {
        if self.left == 0 {
            return Ok(None);
        }
        self.left -= 1;
        seed.deserialize(&mut *self.reader).map(Some)
    }
}

impl<'de> EnumAccess<'de> for &mut Reader<'de> {
    type Error = WireError;
    type Variant = Self;

    #[inline(always)]
    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, Self), WireError> {
        let index: U8Deserializer<WireError> = self.take().into_deserializer();
        Ok((seed.deserialize(index)?, self))
    }
}

impl<'de> VariantAccess<'de> for &mut Reader<'de> {
    type Error = WireError;

    #[inline(always)]
    fn unit_variant(self) -> Result<(), WireError> {
        Ok(())
    }

    #[inline(always)]
    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, WireError> {
        seed.deserialize(self)
    }

    #[inline(always)]
    fn tuple_variant<V: Visitor<'de>>(self, len: usize, visitor: V) -> Result<V::Value, WireError> {
        self.deserialize_tuple(len, visitor)
    }

    #[inline(always)]
    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, WireError> {
        self.deserialize_tuple(fields.len(), visitor)
    }
}
