//! Damaged files give errors or sound meshes, never panics: every prefix and many random changes of good files.

use std::path::Path;

use diffuse_contact_mesh::{Mesh, MeshError};

const DECK: &[u8] = b"\
*Part, name=P
*Node, nset=all
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
*Element, type=S4, elset=e
1, 1, 2,
3, 4
*Element, type=C3D5, elset=w
2, 1, 2,
3, 4
*Nset, nset=n, generate
1, 3, 2
*End Part
*Assembly, name=A
*Instance, name=I, part=P
1., , 2.
0., 0., 0., 1., 1., 1., 30.
*End Instance
*Node
5, 1.
*Element, type=MASS
1, 5
*Elset, elset=e, instance=I
I.e, 1
*Elset, elset=b
-7, 9
*Surface, name=s
e, SNEG
*Surface, name=d, type=NODE
n, 1.
*Nset, nset=r
5, I.1
*End Assembly
";

fn fixture(name: &str) -> Vec<u8> {
    std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)).unwrap()
}

/// Whatever was read has to be sound, and messages have to be printable.
fn judge(result: Result<Mesh, MeshError>) {
    match result {
        Ok(mesh) => {
            assert!(mesh.nodes().iter().flatten().all(|x| x.is_finite()));
            for element in mesh.elements() {
                assert!(element.nodes().iter().all(|&node| node < mesh.nodes().len()));
            }
            for name in mesh.set_names() {
                let _ = mesh.facets(name);
                match mesh.nodes_of(name) {
                    Ok(nodes) => assert!(nodes.iter().all(|&node| node < mesh.nodes().len())),
                    Err(
                        MeshError::UnreadElement { .. }
                        | MeshError::UnsupportedFace { .. }
                        | MeshError::WrongLabel { .. },
                    ) => {}
                    Err(error) => panic!("{error}"),
                }
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// A small generator of pseudo-random numbers (SplitMix64), so that failures can be repeated.
fn next(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

fn damage(original: &[u8], read: impl Fn(&[u8]) -> Result<Mesh, MeshError>) {
    assert!(read(original).is_ok());
    for end in 0..original.len() {
        judge(read(&original[..end]));
    }
    let mut state = 1;
    for _ in 0..5_000 {
        let mut bytes = original.to_vec();
        for _ in 0..=next(&mut state) % 3 {
            let at = next(&mut state) as usize % bytes.len();
            match next(&mut state) % 4 {
                0 => bytes[at] = next(&mut state) as u8,
                1 => bytes[at] = b"0123456789-.,*$\n \"eEnN"[next(&mut state) as usize % 22],
                2 => drop(bytes.remove(at)),
                _ => bytes.insert(at, b"0123456789-.,*$\n \"eEnN"[next(&mut state) as usize % 22]),
            }
        }
        judge(read(&bytes));
    }
}

#[test]
fn damaged_gmsh_ascii() {
    damage(&fixture("block_ascii.msh"), |bytes| Mesh::from_gmsh(bytes, "m.msh"));
}

#[test]
fn damaged_gmsh_binary() {
    damage(&fixture("block_binary.msh"), |bytes| Mesh::from_gmsh(bytes, "m.msh"));
}

#[test]
fn damaged_abaqus() {
    damage(DECK, |bytes| Mesh::from_abaqus(bytes, "m.inp"));
}
