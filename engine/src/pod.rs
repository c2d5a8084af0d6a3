//! Fields of plain numbers for serde: long arrays as one run of bytes, which a binary format copies instead of walking
//! through; shared ones as what they share. Named by `#[serde(with = "...")]` of what the cache of models holds.
//!
//! Bytes are this machine's own: what is written is read on the same one.

/// `Vec` of plain numbers.
pub mod array {
    use std::fmt;
    use std::marker::PhantomData;

    use bytemuck::{NoUninit, Pod};
    use serde::de::{Error, Visitor};
    use serde::{Deserializer, Serializer};

    /// Writes the bytes of the numbers.
    pub fn serialize<T: NoUninit, S: Serializer>(numbers: &[T], to: S) -> Result<S::Ok, S::Error> {
        to.serialize_bytes(bytemuck::cast_slice(numbers))
    }

    /// Numbers from as many bytes as are there, whatever their alignment.
    pub fn deserialize<'de, T: Pod, D: Deserializer<'de>>(from: D) -> Result<Vec<T>, D::Error> {
        from.deserialize_bytes(Bytes(PhantomData))
    }

    struct Bytes<T>(PhantomData<T>);

    impl<T: Pod> Visitor<'_> for Bytes<T> {
        type Value = Vec<T>;

        fn expecting(&self, to: &mut fmt::Formatter) -> fmt::Result {
            write!(to, "bytes, {} a number", size_of::<T>())
        }

        fn visit_bytes<E: Error>(self, bytes: &[u8]) -> Result<Vec<T>, E> {
            if !bytes.len().is_multiple_of(size_of::<T>()) {
                return Err(E::invalid_length(bytes.len(), &self));
            }
            Ok(bytemuck::pod_collect_to_vec(bytes))
        }
    }
}

/// `Arc`; what two share is written twice.
pub mod shared {
    use std::sync::Arc;

    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    /// Writes what is shared.
    pub fn serialize<T: Serialize, S: Serializer>(held: &Arc<T>, to: S) -> Result<S::Ok, S::Error> {
        T::serialize(held, to)
    }

    /// A new one.
    pub fn deserialize<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Arc<T>, D::Error> {
        T::deserialize(from).map(Arc::new)
    }
}

/// `Option<Arc>`; see [`shared`].
pub mod maybe_shared {
    use std::sync::Arc;

    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    /// Writes what is shared.
    pub fn serialize<T: Serialize, S: Serializer>(
        held: &Option<Arc<T>>,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        held.as_deref().serialize(to)
    }

    /// A new one.
    pub fn deserialize<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Option<Arc<T>>, D::Error> {
        Ok(Option::deserialize(from)?.map(Arc::new))
    }
}

/// `Vec` of large things, each written and read by a thread of its own.
pub mod parallel {
    use rayon::prelude::*;
    use serde::de::{DeserializeOwned, Error};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    /// Writes each as a piece of bytes.
    pub fn serialize<T: Serialize + Sync, S: Serializer>(
        things: &[T],
        to: S,
    ) -> Result<S::Ok, S::Error> {
        let pieces: Result<Vec<Piece>, _> = things
            .par_iter()
            .map(|thing| Ok(Piece(postcard::to_allocvec(thing)?)))
            .collect();
        let pieces = pieces.map_err(|error: postcard::Error| serde::ser::Error::custom(error))?;
        pieces.serialize(to)
    }

    /// Reads each from its piece.
    pub fn deserialize<'de, T: DeserializeOwned + Send, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Vec<T>, D::Error> {
        let pieces: Vec<&[u8]> = Vec::deserialize(from)?;
        let things = pieces.par_iter().map(|piece| postcard::from_bytes(piece));
        let things: Result<Vec<T>, postcard::Error> = things.collect();
        things.map_err(D::Error::custom)
    }

    struct Piece(Vec<u8>);

    impl Serialize for Piece {
        fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
            to.serialize_bytes(&self.0)
        }
    }
}
