//! Named arrays of `f32` in a safetensors file.
//!
//! Holds the conversion and its errors. Does not depend on what the arrays mean.
//! Other number types are an error.

use crate::run_folder::{self, FileError};
use safetensors::{Dtype, SafeTensors, tensor::TensorView};
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a tensor file cannot be used.
#[derive(Debug, Error)]
pub enum TensorFileError {
    /// The disk's reason.
    #[error(transparent)]
    File(#[from] FileError),
    /// Not a safetensors file, or a cut one.
    #[error("{path} is not a safetensors file, or it is damaged")]
    Format {
        /// The file.
        path: PathBuf,
        /// Why.
        source: safetensors::SafeTensorError,
    },
    /// An array is missing or does not fit the others.
    #[error("{path}: {name} is missing, not f32, or of a shape that does not match the rest")]
    Shape {
        /// The file.
        path: PathBuf,
        /// The array.
        name: String,
    },
    /// A number is NaN or infinite.
    #[error("{path}: {name} has a value that is NaN or infinite")]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// The array.
        name: String,
    },
}

/// An array in row-major order.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    /// Sizes of the dimensions.
    pub shape: Vec<usize>,
    /// As many as the product of the shape.
    pub numbers: Vec<f32>,
}

/// The arrays of one file.
#[derive(Debug)]
pub struct TensorFile {
    path: PathBuf,
    arrays: BTreeMap<String, Array>,
}

impl TensorFile {
    /// An empty file, to be saved at `path`.
    pub fn new(path: &Path) -> Self {
        Self { path: path.to_owned(), arrays: BTreeMap::new() }
    }

    /// Adds an array; the length of `numbers` must be the product of `shape`.
    pub fn put(&mut self, name: impl Into<String>, shape: &[usize], numbers: Vec<f32>) {
        self.arrays.insert(name.into(), Array { shape: shape.to_vec(), numbers });
    }

    /// Whether there is an array of that name.
    pub fn has(&self, name: &str) -> bool {
        self.arrays.contains_key(name)
    }

    /// Removes and returns an array.
    ///
    /// # Errors
    /// [`TensorFileError::Shape`] where it is missing, [`TensorFileError::NotFinite`].
    pub fn take(&mut self, name: &str) -> Result<Array, TensorFileError> {
        let array = self.arrays.remove(name).ok_or_else(|| self.misfit(name))?;
        if array.numbers.iter().all(|number| number.is_finite()) {
            Ok(array)
        } else {
            Err(TensorFileError::NotFinite { path: self.path.clone(), name: name.to_owned() })
        }
    }

    /// Removes and returns an array of exactly `len` numbers.
    ///
    /// # Errors
    /// As [`Self::take`], and if the length differs.
    pub fn take_len(&mut self, name: &str, len: usize) -> Result<Vec<f32>, TensorFileError> {
        let numbers = self.take(name)?.numbers;
        if numbers.len() == len { Ok(numbers) } else { Err(self.misfit(name)) }
    }

    /// The error for an array whose shape does not match.
    pub fn misfit(&self, name: &str) -> TensorFileError {
        TensorFileError::Shape { path: self.path.clone(), name: name.to_owned() }
    }

    /// Writes the file.
    ///
    /// # Errors
    /// [`TensorFileError::File`], with the old file still in place.
    pub fn save(&self) -> Result<(), TensorFileError> {
        let bytes: Vec<(&String, &Array, Vec<u8>)> = self
            .arrays
            .iter()
            .map(|(name, array)| (name, array, array.numbers.iter().flat_map(|n| n.to_le_bytes()).collect()))
            .collect();
        let format = |source| TensorFileError::Format { path: self.path.clone(), source };
        let views: Vec<_> = bytes
            .iter()
            .map(|(name, array, data)| Ok((*name, TensorView::new(Dtype::F32, array.shape.clone(), data)?)))
            .collect::<Result<_, _>>()
            .map_err(format)?;
        let file = safetensors::serialize(views, &None::<HashMap<String, String>>).map_err(format)?;
        Ok(run_folder::write(&self.path, &file)?)
    }

    /// Reads a whole file.
    ///
    /// # Errors
    /// [`TensorFileError`] if it cannot be read or holds anything but f32.
    pub fn load(path: &Path) -> Result<Self, TensorFileError> {
        let bytes = std::fs::read(path).map_err(FileError::on("read", path))?;
        let format = |source| TensorFileError::Format { path: path.to_owned(), source };
        let mut file = Self::new(path);
        for (name, view) in SafeTensors::deserialize(&bytes).map_err(format)?.tensors() {
            if view.dtype() != Dtype::F32 {
                return Err(file.misfit(&name));
            }
            let numbers = view.data().chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
            file.put(name, view.shape(), numbers.collect());
        }
        Ok(file)
    }
}
