//! Small named control meshes for the tests of subdivision: closed unless the name says otherwise, and
//! consistently oriented, normals outwards.
//!
//! The random ones are what the crack test draws: any mixture of quads, triangles and larger polygons, any
//! valence, creases and corners of any sharpness.

use std::collections::HashSet;
use std::f32::consts::TAU;

use olema::scene::{BoundaryRule, Crease, Scheme, SubdivisionMesh};

/// Small deterministic random numbers (splitmix64).
#[derive(Debug, Clone)]
pub struct Random(u64);

impl Random {
    /// A stream for a seed.
    pub fn new(seed: u64) -> Self {
        Random(seed)
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A whole number below `n`, which is at least 1.
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// A number in [0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1u64 << 24) as f32
    }
}

/// A mesh from lists of vertices.
pub fn mesh(scheme: Scheme, points: Vec<[f32; 3]>, faces: &[Vec<i32>]) -> SubdivisionMesh {
    let counts = faces.iter().map(|f| f.len() as i32).collect();
    SubdivisionMesh::new(scheme, counts, faces.concat(), points)
}

/// The cube of edge 2 around the origin.
pub fn cube() -> SubdivisionMesh {
    let points = (0..8).map(|i| [0, 1, 2].map(|c| if i >> c & 1 == 1 { 1.0 } else { -1.0 })).collect();
    let faces = [
        vec![0, 4, 6, 2],
        vec![1, 3, 7, 5],
        vec![0, 1, 5, 4],
        vec![2, 6, 7, 3],
        vec![0, 2, 3, 1],
        vec![4, 5, 7, 6],
    ];
    mesh(Scheme::CatmullClark, points, &faces)
}

/// A tetrahedron, for Loop or Catmull-Clark.
pub fn tetrahedron(scheme: Scheme) -> SubdivisionMesh {
    let points = vec![[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0]];
    mesh(scheme, points, &[vec![0, 2, 1], vec![0, 1, 3], vec![0, 3, 2], vec![1, 2, 3]])
}

/// An icosahedron: valence 5 everywhere.
pub fn icosahedron(scheme: Scheme) -> SubdivisionMesh {
    let mut points = vec![[0.0, 0.0, 1.0]];
    for ring in 0..2 {
        for i in 0..5 {
            let a = TAU * (i as f32 + 0.5 * ring as f32) / 5.0;
            let z = if ring == 0 { 0.447_213_6 } else { -0.447_213_6 };
            points.push([0.894_427_2 * a.cos(), 0.894_427_2 * a.sin(), z]);
        }
    }
    points.push([0.0, 0.0, -1.0]);
    let mut faces = Vec::new();
    for i in 0..5 {
        let (a, b) = (1 + i, 1 + (i + 1) % 5);
        let (c, d) = (a + 5, b + 5);
        faces.extend([vec![0, a, b], vec![a, c, b], vec![b, c, d], vec![11, d, c]]);
    }
    mesh(scheme, points, &faces)
}

/// A torus of `nu` by `nv` quads, regular everywhere; each at least 3.
pub fn torus(nu: usize, nv: usize) -> SubdivisionMesh {
    let mut points = Vec::new();
    let mut faces = Vec::new();
    for j in 0..nv {
        for i in 0..nu {
            let (a, b) = (TAU * i as f32 / nu as f32, TAU * j as f32 / nv as f32);
            let r = 2.0 + b.cos();
            points.push([r * a.cos(), r * a.sin(), b.sin()]);
            let at = |i: usize, j: usize| ((j % nv) * nu + i % nu) as i32;
            faces.push(vec![at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    mesh(Scheme::CatmullClark, points, &faces)
}

/// A pyramid on a square, its base edges and one side edge creased by `sharpness`.
pub fn pyramid(sharpness: f32) -> SubdivisionMesh {
    let points =
        vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [0.2, 0.1, 1.5]];
    let faces = [vec![0, 3, 2, 1], vec![0, 1, 4], vec![1, 2, 4], vec![2, 3, 4], vec![3, 0, 4]];
    let mut mesh = mesh(Scheme::CatmullClark, points, &faces);
    mesh.creases.push(Crease { vertices: vec![0, 1, 2, 3, 0], sharpness: vec![sharpness] });
    mesh.creases.push(Crease { vertices: vec![1, 4], sharpness: vec![sharpness * 0.5] });
    mesh
}

/// A prism of `n` sides, its ends n-gons; `n` at least 3.
pub fn prism(n: usize) -> SubdivisionMesh {
    let n = n as i32;
    let ring = |z: f32| {
        (0..n).map(move |i| {
            let a = TAU * i as f32 / n as f32;
            [a.cos(), a.sin(), z]
        })
    };
    let points = ring(-0.7).chain(ring(0.7)).collect();
    let mut faces: Vec<Vec<i32>> = vec![(0..n).rev().collect(), (n..2 * n).collect()];
    faces.extend((0..n).map(|i| vec![i, (i + 1) % n, n + (i + 1) % n, n + i]));
    mesh(Scheme::CatmullClark, points, &faces)
}

/// Two poles of valence `n` with a belt of quads and a row of triangles at each; `n` at least 3.
pub fn poles(n: usize, scheme: Scheme) -> SubdivisionMesh {
    let m = n as i32;
    let mut points = vec![[0.0, 0.0, -1.2], [0.0, 0.0, 1.0]];
    for z in [-0.5f32, 0.5] {
        for i in 0..n {
            let a = TAU * i as f32 / n as f32;
            points.push([a.cos(), a.sin(), z + 0.1 * (3.0 * a).sin()]);
        }
    }
    let mut faces = Vec::new();
    for i in 0..m {
        let j = (i + 1) % m;
        faces.extend([vec![0, 2 + j, 2 + i], vec![1, 2 + m + i, 2 + m + j]]);
        if scheme == Scheme::Loop {
            faces.extend([vec![2 + i, 2 + j, 2 + m + j], vec![2 + i, 2 + m + j, 2 + m + i]]);
        } else {
            faces.push(vec![2 + i, 2 + j, 2 + m + j, 2 + m + i]);
        }
    }
    mesh(scheme, points, &faces)
}

/// An open sheet of `nu` by `nv` quads (triangles under Loop), waved.
pub fn open_sheet(nu: usize, nv: usize, boundary: BoundaryRule, scheme: Scheme) -> SubdivisionMesh {
    let mut points = Vec::new();
    let mut faces = Vec::new();
    for j in 0..=nv {
        for i in 0..=nu {
            let (x, y) = (i as f32, j as f32);
            points.push([x + 0.1 * (2.0 * y).sin(), y, 0.5 * (1.7 * x).sin() * (1.3 * y).cos()]);
        }
    }
    for j in 0..nv {
        for i in 0..nu {
            let at = |i: usize, j: usize| (j * (nu + 1) + i) as i32;
            let quad = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            if scheme == Scheme::Loop {
                faces.extend([vec![quad[0], quad[1], quad[2]], vec![quad[0], quad[2], quad[3]]]);
            } else {
                faces.push(quad.to_vec());
            }
        }
    }
    SubdivisionMesh { boundary, ..mesh(scheme, points, &faces) }
}

/// A random closed mesh: a cube with faces drawn out, poked and cut, some merged into larger polygons.
pub fn random_closed(seed: u64) -> SubdivisionMesh {
    let mut random = Random::new(seed);
    let base = cube();
    let mut points = base.points.first().clone();
    let mut faces: Vec<Vec<i32>> = base.indices.chunks(4).map(<[i32]>::to_vec).collect();
    for _ in 0..1 + random.below(6) {
        let ix = random.below(faces.len());
        match random.below(4) {
            0 | 1 => extrude(&mut points, &mut faces, ix, &mut random),
            2 => poke(&mut points, &mut faces, ix, &mut random),
            _ => cut(&mut faces, ix, &mut random),
        }
    }
    for p in points.iter_mut().flatten() {
        *p += 0.3 * (random.unit() - 0.5);
    }
    let mut mesh = mesh(Scheme::CatmullClark, points, &faces);
    sharpen(&mut mesh, &faces, &mut random);
    mesh
}

/// As [`random_closed`], in triangles, for Loop.
pub fn random_closed_triangles(seed: u64) -> SubdivisionMesh {
    let quads = random_closed(seed);
    let mut faces = Vec::new();
    let mut first = 0;
    for &count in &quads.face_vertex_counts {
        let face = &quads.indices[first..first + count as usize];
        faces.extend((1..face.len() - 1).map(|i| vec![face[0], face[i], face[i + 1]]));
        first += count as usize;
    }
    let made = mesh(Scheme::Loop, quads.points.first().clone(), &faces);
    SubdivisionMesh { creases: quads.creases, corners: quads.corners, ..made }
}

/// Draws a face out: its copy moves along the normal, quads join the two.
fn extrude(points: &mut Vec<[f32; 3]>, faces: &mut Vec<Vec<i32>>, ix: usize, random: &mut Random) {
    let face = faces[ix].clone();
    let normal = normal(points, &face);
    let length = 0.5 + random.unit();
    let first = points.len() as i32;
    for &v in &face {
        let p = points[v as usize];
        points.push([0, 1, 2].map(|c| p[c] + normal[c] * length));
    }
    let n = face.len() as i32;
    for i in 0..n {
        let j = (i + 1) % n;
        faces.push(vec![face[i as usize], face[j as usize], first + j, first + i]);
    }
    faces[ix] = (first..first + n).collect();
}

/// Puts a vertex above the middle of a face and triangles around it.
fn poke(points: &mut Vec<[f32; 3]>, faces: &mut Vec<Vec<i32>>, ix: usize, random: &mut Random) {
    let face = faces[ix].clone();
    let normal = normal(points, &face);
    let height = 0.6 * random.unit();
    let middle = [0, 1, 2].map(|c| {
        let sum: f32 = face.iter().map(|&v| points[v as usize][c]).sum();
        sum / face.len() as f32 + normal[c] * height
    });
    let top = points.len() as i32;
    points.push(middle);
    let n = face.len();
    for i in 1..n {
        faces.push(vec![face[i], face[(i + 1) % n], top]);
    }
    faces[ix] = vec![face[0], face[1], top];
}

/// Cuts a face of more than 3 vertices in two along a diagonal.
fn cut(faces: &mut Vec<Vec<i32>>, ix: usize, random: &mut Random) {
    let mut face = faces[ix].clone();
    if face.len() > 3 {
        let shift = random.below(face.len());
        face.rotate_left(shift);
        faces.push(face[..3].to_vec());
        face.remove(1);
        faces[ix] = face;
    }
}

/// Newell's normal, of unit length.
fn normal(points: &[[f32; 3]], face: &[i32]) -> [f32; 3] {
    let mut n = [0.0f32; 3];
    for i in 0..face.len() {
        let (a, b) = (points[face[i] as usize], points[face[(i + 1) % face.len()] as usize]);
        for (c, n) in n.iter_mut().enumerate() {
            let (d, e) = ((c + 1) % 3, (c + 2) % 3);
            *n += (a[d] - b[d]) * (a[e] + b[e]);
        }
    }
    let length = n.iter().map(|x| x * x).sum::<f32>().sqrt();
    n.map(|x| if length > 0.0 { x / length } else { 0.0 })
}

/// Creases up to a third of the edges, and a corner or two.
fn sharpen(mesh: &mut SubdivisionMesh, faces: &[Vec<i32>], random: &mut Random) {
    let levels = [0.3, 1.0, 1.5, 2.0, 3.7, 10.0];
    let mut seen = HashSet::new();
    let share = random.below(4);
    for face in faces {
        for (i, &a) in face.iter().enumerate() {
            let b = face[(i + 1) % face.len()];
            if seen.insert((a.min(b), a.max(b))) && random.below(9) < share {
                let sharpness = vec![levels[random.below(levels.len())]];
                mesh.creases.push(Crease { vertices: vec![a, b], sharpness });
            }
        }
    }
    for _ in 0..random.below(3) {
        let vertex = random.below(mesh.points.first().len()) as i32;
        mesh.corners.push((vertex, levels[random.below(levels.len())]));
    }
}
