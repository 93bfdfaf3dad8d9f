//! Values to bytes.
//!
//! Buffers none of them: each goes straight to its sink. A byte too many
//! is for that to note, not refused here: without a way to fail, no field's
//! outcome has to be looked at.

use super::WireError;
use serde::Serialize;
use serde::ser::{
    Impossible, SerializeSeq, SerializeStruct, SerializeStructVariant, SerializeTuple, Serializer,
};

/// Where bytes go, one after the other.
pub trait Sink {
    /// The next one.
    fn put(&mut self, byte: u8);
}

/// Writes messages to a sink.
pub struct Writer<S>(pub S);

impl<S: Sink> Writer<S> {
    #[inline(never)]
    fn put(&mut self, byte: u8) {
        self.0.put(byte);
    }

    #[inline(never)]
    fn put_varint(&mut self, mut value: u32) {
        while value >= 0x80 {
            self.put(value as u8 | 0x80);
            value >>= 7;
        }
        self.put(value as u8);
    }

    #[inline(never)]
    fn put_all(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.put(byte));
    }
}

type Done = Result<(), WireError>;
type Unused = Impossible<(), WireError>;

impl<S: Sink> Serializer for &mut Writer<S> {
    type Ok = ();
    type Error = WireError;
    type SerializeSeq = Self;
    type SerializeTuple = Self;
    type SerializeTupleStruct = Unused;
    type SerializeTupleVariant = Unused;
    type SerializeMap = Unused;
    type SerializeStruct = Self;
    type SerializeStructVariant = Self;

    #[inline(always)]
    fn serialize_bool(self, v: bool) -> Done {
        self.put(u8::from(v));
        Ok(())
    }

    #[inline(always)]
    fn serialize_u8(self, v: u8) -> Done {
        self.put(v);
        Ok(())
    }

    #[inline(always)]
    fn serialize_i8(self, v: i8) -> Done {
        self.put(v as u8);
        Ok(())
    }

    #[inline(always)]
    fn serialize_u16(self, v: u16) -> Done {
        self.put_varint(u32::from(v));
        Ok(())
    }

    #[inline(always)]
    fn serialize_u32(self, v: u32) -> Done {
        self.put_varint(v);
        Ok(())
    }

    #[inline(always)]
    fn serialize_i16(self, v: i16) -> Done {
        self.put_varint(u32::from((v << 1 ^ v >> 15) as u16));
        Ok(())
    }

    #[inline(always)]
    fn serialize_i32(self, v: i32) -> Done {
        self.put_varint((v << 1 ^ v >> 31) as u32);
        Ok(())
    }

    fn serialize_i64(self, _: i64) -> Done {
        Err(WireError)
    }

    fn serialize_u64(self, _: u64) -> Done {
        Err(WireError)
    }

    fn serialize_f32(self, _: f32) -> Done {
        Err(WireError)
    }

    fn serialize_f64(self, _: f64) -> Done {
        Err(WireError)
    }

    fn serialize_char(self, _: char) -> Done {
        Err(WireError)
    }

    fn serialize_str(self, _: &str) -> Done {
        Err(WireError)
    }

    #[inline(always)]
    fn serialize_bytes(self, v: &[u8]) -> Done {
        self.put_varint(v.len() as u32);
        self.put_all(v);
        Ok(())
    }

    #[inline(always)]
    fn serialize_none(self) -> Done {
        self.put(0);
        Ok(())
    }

    #[inline(always)]
    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Done {
        self.put(1);
        value.serialize(self)
    }

    #[inline(always)]
    fn serialize_unit(self) -> Done {
        Ok(())
    }

    #[inline(always)]
    fn serialize_unit_struct(self, _: &'static str) -> Done {
        Ok(())
    }

    #[inline(always)]
    fn serialize_unit_variant(self, _: &'static str, index: u32, _: &'static str) -> Done {
        self.put(index as u8);
        Ok(())
    }

    #[inline(always)]
    fn serialize_newtype_struct<T: Serialize + ?Sized>(self, _: &'static str, value: &T) -> Done {
        value.serialize(self)
    }

    #[inline(always)]
    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        index: u32,
        _: &'static str,
        value: &T,
    ) -> Done {
        self.put(index as u8);
        value.serialize(self)
    }

    #[inline(always)]
    fn serialize_seq(self, len: Option<usize>) -> Result<Self, WireError> {
        self.put_varint(len.ok_or(WireError)? as u32);
        Ok(self)
    }

    #[inline(always)]
    fn serialize_tuple(self, _: usize) -> Result<Self, WireError> {
        Ok(self)
    }

    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Unused, WireError> {
        Err(WireError)
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Unused, WireError> {
        Err(WireError)
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Unused, WireError> {
        Err(WireError)
    }

    #[inline(always)]
    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Self, WireError> {
        Ok(self)
    }

    #[inline(always)]
    fn serialize_struct_variant(
        self,
        _: &'static str,
        index: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self, WireError> {
        self.put(index as u8);
        Ok(self)
    }

    fn collect_str<T: core::fmt::Display + ?Sized>(self, _: &T) -> Done {
        Err(WireError)
    }

    fn is_human_readable(&self) -> bool {
        false
    }
}

macro_rules! each_value {
    ($($part:ident $method:ident $(($key:ty))?;)*) => {$(
        impl<S: Sink> $part for &mut Writer<S> {
            type Ok = ();
            type Error = WireError;

            #[inline(always)]
            fn $method<T: Serialize + ?Sized>(&mut self, $(_: $key,)? value: &T) -> Done {
                value.serialize(&mut **self)
            }

            #[inline(always)]
            fn end(self) -> Done {
                Ok(())
            }
        }
    )*};
}

each_value! {
    SerializeSeq serialize_element;
    SerializeTuple serialize_element;
    SerializeStruct serialize_field (&'static str);
    SerializeStructVariant serialize_field (&'static str);
}
