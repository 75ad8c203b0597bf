//! The ball less two bores meshed by fidget, a peer of the bench.
//!
//!     fidget-peer DEPTH FILE
//!
//! Prints the seconds of the best of three runs. FILE gets the number of vertices and triangles as
//! 64-bit numbers, then coordinates as 32-bit floats and corners as 32-bit numbers.

use fidget::context::Tree;
use fidget::jit::JitShape;
use fidget::mesh::{Mesh, Octree, Settings};
use std::error::Error;
use std::io::Write;
use std::time::Instant;

/// The library meshes the cube from -1 to 1; models are in these units.
const SCALE: f32 = 64.0;

fn part() -> Tree {
    let [x, y, z] = [Tree::x() * SCALE, Tree::y() * SCALE, Tree::z() * SCALE];
    let bore = |a: &Tree, b: &Tree| (a.square() + b.square()).sqrt() - 15.0;
    let ball = (x.square() + y.square() + z.square()).sqrt() - 50.0;
    ball.max(-bore(&x, &y)).max(-bore(&x, &z))
}

fn mesh(depth: u8) -> Result<Mesh, Box<dyn Error>> {
    let shape = JitShape::from(part()).try_into()?;
    let settings = Settings { depth, ..Default::default() };
    let octree = Octree::build(&shape, &settings).ok_or("cancelled")?;
    Ok(octree.walk_dual())
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, depth, path] = arguments.as_slice() else {
        return Err("usage: fidget-peer DEPTH FILE".into());
    };
    let mut best = f64::INFINITY;
    let mut result = None;
    for _ in 0..3 {
        let start = Instant::now();
        result = Some(mesh(depth.parse()?)?);
        best = best.min(start.elapsed().as_secs_f64());
    }
    let mesh = result.ok_or("no run")?;
    let mut bytes = Vec::new();
    bytes.extend((mesh.vertices.len() as u64).to_le_bytes());
    bytes.extend((mesh.triangles.len() as u64).to_le_bytes());
    for v in &mesh.vertices {
        for i in 0..3 {
            bytes.extend((v[i] * SCALE).to_le_bytes());
        }
    }
    for t in &mesh.triangles {
        for i in 0..3 {
            bytes.extend((t[i] as u32).to_le_bytes());
        }
    }
    std::fs::File::create(path)?.write_all(&bytes)?;
    println!("{best}");
    Ok(())
}
