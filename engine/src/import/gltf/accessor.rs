//! Accessors to numbers: typed, strided, normalised and sparse, read only where there are bytes.

use gltf::accessor::sparse::IndexType;
use gltf::accessor::{Accessor, DataType, Dimensions};

use super::file::File;

impl File {
    /// The numbers of an accessor of this shape, element by element. Integers that stand for shares come out as shares
    /// (3.6.2.2 of the specification).
    pub fn numbers(&self, accessor: &Accessor, shape: Dimensions) -> Result<Vec<f32>, String> {
        let place = |why: String| format!("accessors[{}]: {why}", accessor.index());
        if accessor.dimensions() != shape {
            let found = accessor.dimensions();
            return Err(place(format!("it is {found:?} where {shape:?} is needed")));
        }
        let share = accessor.normalized();
        let data_type = accessor.data_type();
        let read = |bytes: &[u8]| number(bytes, data_type, share);
        self.read(accessor, shape.multiplicity(), read)
            .map_err(place)
    }

    /// The whole numbers of an accessor of scalars.
    pub fn indices(&self, accessor: &Accessor) -> Result<Vec<u32>, String> {
        self.whole_numbers(accessor, Dimensions::Scalar)
    }

    /// The unsigned numbers of an accessor of this shape, element by element.
    pub fn whole_numbers(
        &self,
        accessor: &Accessor,
        shape: Dimensions,
    ) -> Result<Vec<u32>, String> {
        let place = |why: String| format!("accessors[{}]: {why}", accessor.index());
        let data_type = accessor.data_type();
        let unsigned = matches!(data_type, DataType::U8 | DataType::U16 | DataType::U32);
        if accessor.dimensions() != shape || !unsigned {
            let found = accessor.dimensions();
            return Err(place(format!(
                "it is {found:?} of {data_type:?} where unsigned {shape:?} is needed"
            )));
        }
        let read = |bytes: &[u8]| whole(bytes);
        self.read(accessor, shape.multiplicity(), read)
            .map_err(place)
    }

    fn read<T: Copy + Default>(
        &self,
        accessor: &Accessor,
        width: usize,
        read: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, String> {
        let size = accessor.data_type().size();
        let element = size * width;
        let matrix = matches!(
            accessor.dimensions(),
            Dimensions::Mat2 | Dimensions::Mat3 | Dimensions::Mat4
        );
        if matrix && accessor.data_type() != DataType::F32 {
            return Err("matrices of integers are not supported".into());
        }
        let count = accessor.count();
        let mut numbers = Vec::new();
        if let Some(view) = accessor.view() {
            let stride = view.stride().unwrap_or(element);
            let bytes = self.view(&view)?;
            let elements = elements(bytes, accessor.offset(), count, stride, element)?;
            self.spend(count.saturating_mul(width))?;
            for element in elements {
                numbers.extend(element.chunks_exact(size).map(&read));
            }
        } else {
            self.spend(count.saturating_mul(width))?;
            numbers.resize(count * width, T::default());
        }
        let Some(sparse) = accessor.sparse() else {
            return Ok(numbers);
        };
        let (indices, values) = (sparse.indices(), sparse.values());
        let index_size = match indices.index_type() {
            IndexType::U8 => 1,
            IndexType::U16 => 2,
            IndexType::U32 => 4,
        };
        let places = self.view(&indices.view())?;
        let places = elements(
            places,
            indices.offset(),
            sparse.count(),
            index_size,
            index_size,
        )?;
        let given = self.view(&values.view())?;
        let given = elements(given, values.offset(), sparse.count(), element, element)?;
        for (place, bytes) in places.zip(given) {
            let place = whole(place) as usize;
            if place >= count {
                return Err(format!("a sparse value for element {place} of {count}"));
            }
            let row = &mut numbers[place * width..(place + 1) * width];
            for (number, bytes) in row.iter_mut().zip(bytes.chunks_exact(size)) {
                *number = read(bytes);
            }
        }
        Ok(numbers)
    }
}

/// The elements of a view, if it has them all.
fn elements(
    bytes: &[u8],
    offset: usize,
    count: usize,
    stride: usize,
    size: usize,
) -> Result<impl Iterator<Item = &[u8]>, String> {
    let end = count
        .saturating_sub(1)
        .checked_mul(stride)
        .and_then(|last| last.checked_add(size)?.checked_add(offset));
    let there = count == 0 || end.is_some_and(|end| end <= bytes.len());
    if !there || stride == 0 {
        return Err(format!(
            "{count} elements {stride} bytes apart from byte {offset} on, but its view has {} bytes",
            bytes.len()
        ));
    }
    Ok((0..count).map(move |i| &bytes[offset + i * stride..][..size]))
}

fn whole(bytes: &[u8]) -> u32 {
    let mut four = [0; 4];
    four[..bytes.len()].copy_from_slice(bytes);
    u32::from_le_bytes(four)
}

/// A number of so many bytes as its type has.
fn number(bytes: &[u8], data_type: DataType, share: bool) -> f32 {
    let (number, most) = match (data_type, bytes) {
        (DataType::I8, &[a]) => (f32::from(a as i8), 127.0),
        (DataType::U8, &[a]) => (f32::from(a), 255.0),
        (DataType::I16, &[a, b]) => (f32::from(i16::from_le_bytes([a, b])), 32767.0),
        (DataType::U16, &[a, b]) => (f32::from(u16::from_le_bytes([a, b])), 65535.0),
        (DataType::F32, &[a, b, c, d]) => return f32::from_le_bytes([a, b, c, d]),
        _ => (whole(bytes) as f32, u32::MAX as f32),
    };
    if share {
        (number / most).max(-1.0)
    } else {
        number
    }
}
