//! Uniform subdivision as plainly as it can be written: whole meshes, maps from edges to faces, every rule
//! straight from the papers. It shares no line with the library and is what the library is held against.
//!
//! Every face remembers where its corners lie: base quad and (u, v), or face and barycentric under Loop.

use std::collections::{BTreeMap, HashMap};

use glam::DVec3;
use olema::scene::{BoundaryRule, Scheme, SubdivisionMesh};

pub type Edge = (usize, usize);

pub fn edge(a: usize, b: usize) -> Edge {
    (a.min(b), a.max(b))
}

#[derive(Clone)]
pub struct Face {
    pub vertices: Vec<usize>,
    /// Base quad, or triangle under Loop.
    pub domain: usize,
    /// Place of each corner in the domain: (u, v), or barycentric.
    pub place: Vec<[f64; 3]>,
}

#[derive(Clone)]
pub struct Uniform {
    pub is_loop: bool,
    pub points: Vec<DVec3>,
    pub faces: Vec<Face>,
    pub edge_sharpness: HashMap<Edge, f64>,
    pub vertex_sharpness: HashMap<usize, f64>,
    pub edge_faces: BTreeMap<Edge, Vec<usize>>,
    pub vertex_edges: Vec<Vec<Edge>>,
    pub vertex_faces: Vec<Vec<usize>>,
}

fn sharp(s: f32) -> f64 {
    if s >= 10.0 { f64::INFINITY } else { f64::from(s) }
}

impl Uniform {
    pub fn new(mesh: &SubdivisionMesh) -> Uniform {
        let is_loop = mesh.scheme == Scheme::Loop;
        let mut faces = Vec::new();
        let mut first = 0;
        for &n in &mesh.face_vertex_counts {
            let vertices: Vec<usize> =
                mesh.indices[first..first + n as usize].iter().map(|&v| v as usize).collect();
            first += n as usize;
            let place = match is_loop {
                true => vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                false => vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
            };
            faces.push(Face { vertices, domain: faces.len(), place });
        }
        let mut made = Uniform {
            is_loop,
            points: mesh.points.first().iter().map(|p| DVec3::from(p.map(f64::from))).collect(),
            faces,
            edge_sharpness: HashMap::new(),
            vertex_sharpness: mesh.corners.iter().map(|&(v, s)| (v as usize, sharp(s))).collect(),
            edge_faces: BTreeMap::new(),
            vertex_edges: Vec::new(),
            vertex_faces: Vec::new(),
        };
        for crease in &mesh.creases {
            for (i, pair) in crease.vertices.windows(2).enumerate() {
                let s = crease.sharpness[i.min(crease.sharpness.len() - 1)];
                made.edge_sharpness.insert(edge(pair[0] as usize, pair[1] as usize), sharp(s));
            }
        }
        made.connect();
        for v in 0..made.points.len() {
            if made.vertex_faces[v].len() == 1 && mesh.boundary == BoundaryRule::EdgeAndCorner {
                made.vertex_sharpness.insert(v, f64::INFINITY);
            }
        }
        made
    }

    fn connect(&mut self) {
        self.edge_faces.clear();
        self.vertex_edges = vec![Vec::new(); self.points.len()];
        self.vertex_faces = vec![Vec::new(); self.points.len()];
        for (f, face) in self.faces.iter().enumerate() {
            for (i, &a) in face.vertices.iter().enumerate() {
                let b = face.vertices[(i + 1) % face.vertices.len()];
                self.edge_faces.entry(edge(a, b)).or_default().push(f);
                self.vertex_faces[a].push(f);
            }
        }
        for (&e, faces) in &self.edge_faces {
            self.vertex_edges[e.0].push(e);
            self.vertex_edges[e.1].push(e);
            if faces.len() == 1 {
                self.edge_sharpness.insert(e, f64::INFINITY);
            }
        }
    }

    pub fn sharpness(&self, e: Edge) -> f64 {
        self.edge_sharpness.get(&e).copied().unwrap_or(0.0)
    }

    fn middle(&self, face: usize) -> DVec3 {
        let v = &self.faces[face].vertices;
        v.iter().map(|&v| self.points[v]).sum::<DVec3>() / v.len() as f64
    }

    fn other(&self, e: Edge, v: usize) -> usize {
        if e.0 == v { e.1 } else { e.0 }
    }

    fn edge_point(&self, e: Edge) -> DVec3 {
        let (a, b) = (self.points[e.0], self.points[e.1]);
        let s = self.sharpness(e);
        let sharp = (a + b) / 2.0;
        if s >= 1.0 {
            return sharp;
        }
        let faces = &self.edge_faces[&e];
        let smooth = if self.is_loop {
            let far = |f: usize| {
                let v = self.faces[f].vertices.iter().find(|&&v| v != e.0 && v != e.1);
                self.points[*v.unwrap()]
            };
            (a + b) * 0.375 + (far(faces[0]) + far(faces[1])) * 0.125
        } else {
            (a + b + self.middle(faces[0]) + self.middle(faces[1])) / 4.0
        };
        smooth + (sharp - smooth) * s
    }

    /// The vertex by the rule for so many levels of sharpness gone.
    fn ruled(&self, v: usize, gone: f64) -> DVec3 {
        let p = self.points[v];
        let left = |s: f64| (s - gone).max(0.0);
        let sharp: Vec<Edge> =
            self.vertex_edges[v].iter().copied().filter(|&e| left(self.sharpness(e)) > 0.0).collect();
        let corner = self.vertex_sharpness.get(&v).copied().unwrap_or(0.0);
        if left(corner) > 0.0 || sharp.len() > 2 {
            return p;
        }
        if sharp.len() == 2 {
            let ends = self.points[self.other(sharp[0], v)] + self.points[self.other(sharp[1], v)];
            return p * 0.75 + ends * 0.125;
        }
        let n = self.vertex_faces[v].len() as f64;
        let ends: DVec3 = self.vertex_edges[v].iter().map(|&e| self.points[self.other(e, v)]).sum();
        if self.is_loop {
            let root = 0.375 + 0.25 * (std::f64::consts::TAU / n).cos();
            let w = (0.625 - root * root) / n;
            p * (1.0 - n * w) + ends * w
        } else {
            let middles: DVec3 = self.vertex_faces[v].iter().map(|&f| self.middle(f)).sum();
            p * ((n - 2.0) / n) + (ends + middles) / (n * n)
        }
    }

    fn vertex_point(&self, v: usize) -> DVec3 {
        // What reaches 0 in this level: its mean sharpness says how much the rule before still counts.
        let all = self.vertex_edges[v].iter().map(|&e| self.sharpness(e));
        let ending: Vec<f64> =
            all.chain(self.vertex_sharpness.get(&v).copied()).filter(|&s| s > 0.0 && s <= 1.0).collect();
        if ending.is_empty() {
            return self.ruled(v, 0.0);
        }
        let weight = ending.iter().sum::<f64>() / ending.len() as f64;
        self.ruled(v, 0.0) * weight + self.ruled(v, 1.0) * (1.0 - weight)
    }

    pub fn refine(&self) -> Uniform {
        let mut points: Vec<DVec3> = (0..self.points.len()).map(|v| self.vertex_point(v)).collect();
        let mut edge_ids = HashMap::new();
        let mut edge_sharpness = HashMap::new();
        let decay = |s: f64| (s - 1.0).max(0.0);
        for &e in self.edge_faces.keys() {
            let id = points.len();
            points.push(self.edge_point(e));
            edge_ids.insert(e, id);
            edge_sharpness.insert(edge(e.0, id), decay(self.sharpness(e)));
            edge_sharpness.insert(edge(e.1, id), decay(self.sharpness(e)));
        }
        let mut faces = Vec::new();
        let mut next_domain = 0;
        // Other polygons than quads are there in the first level only.
        let is_first = self.faces.iter().any(|f| f.vertices.len() != 4);
        for (f, face) in self.faces.iter().enumerate() {
            let n = face.vertices.len();
            let v = |i: usize| face.vertices[i % n];
            let e = |i: usize| edge_ids[&edge(v(i), v(i + 1))];
            if self.is_loop {
                self.split_triangle(face, e, &mut faces);
                continue;
            }
            let middle = points.len();
            points.push(self.middle(f));
            let domain = if is_first { next_domain } else { face.domain };
            next_domain += if n == 4 { 1 } else { n };
            for i in 0..n {
                let vertices = vec![v(i), e(i), middle, e(i + n - 1)];
                if n == 4 {
                    let at = |a: usize, b: usize| {
                        let (a, b) = (face.place[a % 4], face.place[b % 4]);
                        [0, 1, 2].map(|c| (a[c] + b[c]) / 2.0)
                    };
                    let place = vec![at(i, i), at(i, i + 1), at(0, 2), at(i, i + 3)];
                    // Keep the domain's own order of corners.
                    let mut child = Face { vertices, domain, place };
                    child.vertices.rotate_right(i);
                    child.place.rotate_right(i);
                    faces.push(child);
                } else {
                    let place = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
                    faces.push(Face { vertices, domain: domain + i, place });
                }
            }
        }
        let vertex_sharpness = self.vertex_sharpness.iter().map(|(&v, &s)| (v, decay(s))).collect();
        let mut fine = Uniform {
            is_loop: self.is_loop,
            points,
            faces,
            edge_sharpness,
            vertex_sharpness,
            edge_faces: BTreeMap::new(),
            vertex_edges: Vec::new(),
            vertex_faces: Vec::new(),
        };
        fine.connect();
        fine
    }

    fn split_triangle(&self, face: &Face, e: impl Fn(usize) -> usize, faces: &mut Vec<Face>) {
        let mid = |a: usize, b: usize| [0, 1, 2].map(|c| (face.place[a][c] + face.place[b][c]) / 2.0);
        let m = [mid(0, 1), mid(1, 2), mid(2, 0)];
        for i in 0..3 {
            let p = (i + 2) % 3;
            let vertices = vec![face.vertices[i], e(i), e(p)];
            faces.push(Face { vertices, domain: face.domain, place: vec![face.place[i], m[i], m[p]] });
        }
        faces.push(Face { vertices: vec![e(0), e(1), e(2)], domain: face.domain, place: m.to_vec() });
    }

    pub fn sharp_edges(&self, v: usize) -> Vec<Edge> {
        self.vertex_edges[v].iter().copied().filter(|&e| self.sharpness(e) > 0.0).collect()
    }

    /// Where the vertex ends up, by the published masks. All sharpness must be gone or infinite.
    pub fn limit(&self, v: usize) -> DVec3 {
        let p = self.points[v];
        let sharp = self.sharp_edges(v);
        if self.vertex_sharpness.get(&v).is_some_and(|&s| s > 0.0) || sharp.len() > 2 {
            return p;
        }
        if sharp.len() == 2 {
            let ends = self.points[self.other(sharp[0], v)] + self.points[self.other(sharp[1], v)];
            return (p * 4.0 + ends) / 6.0;
        }
        let n = self.vertex_faces[v].len() as f64;
        let ends: DVec3 = self.vertex_edges[v].iter().map(|&e| self.points[self.other(e, v)]).sum();
        if self.is_loop {
            let root = 0.375 + 0.25 * (std::f64::consts::TAU / n).cos();
            let beta = (0.625 - root * root) / n;
            let w = 1.0 / (n + 3.0 / (8.0 * beta));
            return p * (1.0 - n * w) + ends * w;
        }
        let far: DVec3 = self.vertex_faces[v]
            .iter()
            .map(|&f| {
                let face = &self.faces[f].vertices;
                let at = face.iter().position(|&w| w == v).unwrap();
                self.points[face[(at + 2) % 4]]
            })
            .sum();
        (p * (n * n) + ends * 4.0 + far) / (n * (n + 5.0))
    }

    /// The normal at a vertex of four quads or six triangles with nothing sharp, by the B-spline's masks.
    pub fn regular_normal(&self, v: usize) -> Option<DVec3> {
        let faces = &self.vertex_faces[v];
        let regular = if self.is_loop { 6 } else { 4 };
        if faces.len() != regular || !self.sharp_edges(v).is_empty() {
            return None;
        }
        if self.vertex_sharpness.get(&v).is_some_and(|&s| s > 0.0) {
            return None;
        }
        // Go around counter-clockwise: from a face's next vertex to the one before it.
        let in_face = |f: usize, step: usize| {
            let face = &self.faces[f].vertices;
            let at = face.iter().position(|&w| w == v).unwrap();
            face[(at + step) % face.len()]
        };
        let last = if self.is_loop { 2 } else { 3 };
        let mut ring = vec![faces[0]];
        while ring.len() < regular {
            let from = in_face(ring[ring.len() - 1], last);
            ring.push(*faces.iter().find(|&&f| in_face(f, 1) == from)?);
        }
        let e = |k: usize| self.points[in_face(ring[k % regular], 1)];
        if self.is_loop {
            let cos = |i: i32| f64::from(i).mul_add(std::f64::consts::FRAC_PI_3, 0.0).cos();
            let t = |k: i32| (0..6).map(|i| e(i as usize) * cos(i - k)).sum::<DVec3>();
            return t(0).cross(t(1)).try_normalize();
        }
        let f = |k: usize| self.points[in_face(ring[k % 4], 2)];
        let t = |k: usize| (e(k) - e(k + 2)) * 4.0 + f(k) + f(k + 3) - f(k + 1) - f(k + 2);
        t(0).cross(t(1)).try_normalize()
    }
}
