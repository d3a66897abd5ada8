//! Meshes from files of any format.

use std::collections::BTreeSet;
use std::path::Path;

use crate::error::MeshError;
use crate::mesh::Mesh;
use crate::{abaqus, gmsh};

impl Mesh {
    /// Reads a mesh file. The extension tells the format (`.msh`, `.inp`); if it does not, the content does.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, MeshError> {
        let path = path.as_ref();
        let bytes =
            std::fs::read(path).map_err(|cause| MeshError::Read { path: path.to_path_buf(), cause })?;
        Self::from_bytes(&bytes, path)
    }

    /// Reads the content of a mesh file, as [`read`](Self::read) does. `path` tells the format and is used in messages.
    pub fn from_bytes(bytes: &[u8], path: impl AsRef<Path>) -> Result<Self, MeshError> {
        let path = path.as_ref();
        let extension = path.extension().and_then(|extension| extension.to_str()).map(str::to_lowercase);
        match extension.as_deref() {
            Some("msh") => Self::from_gmsh(bytes, path),
            Some("inp") => Self::from_abaqus(bytes, path),
            _ => match begin(bytes) {
                Some(b'$') => Self::from_gmsh(bytes, path),
                Some(b'*') => Self::from_abaqus(bytes, path),
                _ => Err(MeshError::UnknownFormat { path: path.to_path_buf() }),
            },
        }
    }

    /// Reads one instance of an Abaqus file: its part where the assembly has it, and the sets and surfaces of part and assembly as
    /// far as they are its own. The other functions need this only if there are several instances.
    pub fn read_instance(path: impl AsRef<Path>, instance: &str) -> Result<Self, MeshError> {
        let path = path.as_ref();
        let bytes =
            std::fs::read(path).map_err(|cause| MeshError::Read { path: path.to_path_buf(), cause })?;
        if begin(&bytes) == Some(&b'$') {
            return Err(MeshError::NoInstances { path: path.to_path_buf(), name: instance.into() });
        }
        Self::abaqus(&bytes, path, Some(instance))
    }

    /// Reads the content of a Gmsh file, MSH 4.1, ASCII or binary. `path` is only used in messages.
    pub fn from_gmsh(bytes: &[u8], path: impl AsRef<Path>) -> Result<Self, MeshError> {
        gmsh::read(bytes, path.as_ref())?.unless_empty(path.as_ref())
    }

    /// Reads the content of an Abaqus input file. `path` is only used in messages.
    pub fn from_abaqus(bytes: &[u8], path: impl AsRef<Path>) -> Result<Self, MeshError> {
        Self::abaqus(bytes, path.as_ref(), None)
    }

    fn abaqus(bytes: &[u8], path: &Path, instance: Option<&str>) -> Result<Self, MeshError> {
        let mesh = abaqus::read(bytes, instance).map_err(|fault| fault.in_text(path, bytes))?;
        mesh.unless_empty(path)
    }

    fn unless_empty(self, path: &Path) -> Result<Self, MeshError> {
        let what = match (self.nodes.is_empty(), self.elements.is_empty()) {
            (true, _) => "nodes",
            (false, true) if !self.unread.elements.is_empty() => {
                let kinds: BTreeSet<&str> =
                    self.unread.elements.iter().map(|element| element.kind.as_str()).collect();
                let kinds = kinds.into_iter().map(String::from).collect();
                return Err(MeshError::NothingSupported { path: path.to_path_buf(), kinds });
            }
            (false, true) => "elements",
            (false, false) => return Ok(self),
        };
        Err(MeshError::Empty { path: path.to_path_buf(), what })
    }
}

/// The first character of a text that is neither space nor the mark that some editors begin a file with.
fn begin(bytes: &[u8]) -> Option<&u8> {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start().first()
}
