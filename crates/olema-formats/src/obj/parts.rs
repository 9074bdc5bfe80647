//! Parts: which faces of a file are one surface.
//!
//! In: an [`Obj`]. Out: a control mesh for each run of groups that share no vertex with the others. Groups that
//! share one stay together, whatever their names: cut apart, each would end in a border where the surface goes on.

use std::collections::BTreeMap;

use olema::scene::{Class, Crease, PrimVar, Scheme, SubdivisionMesh, VarType, VarValues};

use super::{Corner, Obj};

/// Faces that hang together or are named together.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Names of its groups, or empty.
    pub name: String,
    /// Line of the statement that began its first group; that of its first face where there is none.
    pub line: u32,
    /// Its faces, with the tags that name them or their vertices.
    pub mesh: SubdivisionMesh,
}

/// Where a vertex or face of the file has gone.
#[derive(Debug, Clone, Copy)]
struct Place {
    part: usize,
    ix: i32,
}

impl Obj {
    /// The file's faces as control meshes, in the order of their first faces. Faces that name a position which is
    /// not there are left out (the reader has said so); without any, and with one part, faces and vertices keep
    /// their numbers.
    pub fn parts(&self, scheme: Scheme) -> Vec<Part> {
        let faces = self.whole_faces();
        let part_of_group = self.join_groups(&faces);
        let mut names: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (group, root) in part_of_group.iter().enumerate() {
            if let Some(root) = root {
                names.entry(*root).or_default().push(group);
            }
        }
        if faces.len() == self.face_counts.len() && names.len() == 1 {
            let groups = names.into_values().next().unwrap_or_default();
            return vec![self.part(&groups, self.subdivision_mesh(scheme))];
        }
        let number: BTreeMap<usize, usize> = names.keys().enumerate().map(|(ix, root)| (*root, ix)).collect();
        let part_of_face = |group: usize| part_of_group[group].and_then(|root| number.get(&root).copied());
        let meshes = self.cut(scheme, &faces, names.len(), part_of_face);
        names.values().zip(meshes).map(|(groups, mesh)| self.part(groups, mesh)).collect()
    }

    /// Index, group and corners of every face that has all its positions.
    fn whole_faces(&self) -> Vec<(usize, usize, &[Corner])> {
        let (mut faces, mut first, mut group) = (Vec::new(), 0, 0);
        for (ix, count) in self.face_counts.iter().enumerate() {
            while self.groups.get(group + 1).is_some_and(|g| g.first_face as usize <= ix) {
                group += 1;
            }
            let end = first + usize::try_from(*count).unwrap_or(0);
            let corners = self.corners.get(first..end).unwrap_or(&[]);
            first = end;
            if corners.iter().all(|c| c.position >= 0) {
                faces.push((ix, group, corners));
            }
        }
        faces
    }

    /// For each group that has faces, the first group that it hangs together with.
    fn join_groups(&self, faces: &[(usize, usize, &[Corner])]) -> Vec<Option<usize>> {
        let mut parent: Vec<usize> = (0..self.groups.len()).collect();
        let mut has_faces = vec![false; self.groups.len()];
        let mut user = vec![usize::MAX; self.positions.len()];
        for (_, group, corners) in faces {
            has_faces[*group] = true;
            for corner in *corners {
                let user = &mut user[corner.position as usize];
                if *user == usize::MAX {
                    *user = *group;
                } else {
                    let (a, b) = (root(&mut parent, *user), root(&mut parent, *group));
                    parent[a.max(b)] = a.min(b);
                }
            }
        }
        (0..parent.len()).map(|g| has_faces[g].then(|| root(&mut parent, g))).collect()
    }

    /// A control mesh a part, its vertices and faces numbered anew.
    fn cut(
        &self,
        scheme: Scheme,
        faces: &[(usize, usize, &[Corner])],
        num_parts: usize,
        part_of: impl Fn(usize) -> Option<usize>,
    ) -> Vec<SubdivisionMesh> {
        let empty = SubdivisionMesh::new(scheme, Vec::new(), Vec::new(), Vec::new());
        let mut meshes = vec![self.rules(empty); num_parts];
        let mut st: Vec<Option<Vec<f32>>> = vec![Some(Vec::new()); num_parts];
        let mut vertices: Vec<Option<Place>> = vec![None; self.positions.len()];
        let mut places: Vec<Option<Place>> = vec![None; self.face_counts.len()];
        for (face, group, corners) in faces {
            let Some(part) = part_of(*group) else { continue };
            let mesh = &mut meshes[part];
            places[*face] = Some(Place { part, ix: mesh.face_vertex_counts.len() as i32 });
            mesh.face_vertex_counts.push(corners.len() as i32);
            for corner in *corners {
                let points = &mut mesh.points.values[0];
                let place = *vertices[corner.position as usize].get_or_insert_with(|| {
                    points.push(self.positions[corner.position as usize]);
                    Place { part, ix: points.len() as i32 - 1 }
                });
                mesh.indices.push(place.ix);
                match (&mut st[part], self.texcoord(corner)) {
                    (Some(values), Some(uv)) => values.extend(uv),
                    (values, _) => *values = None,
                }
            }
        }
        for (mesh, st) in meshes.iter_mut().zip(st) {
            mesh.vars.extend(st.and_then(st_var));
        }
        self.share_tags(&mut meshes, &vertices, &places);
        meshes
    }

    /// Gives each tag to the part that its first vertex or its face is in. Of a chain that goes on in another part
    /// the vertices there become -1, which the limit surface tells of.
    fn share_tags(
        &self,
        meshes: &mut [SubdivisionMesh],
        vertices: &[Option<Place>],
        faces: &[Option<Place>],
    ) {
        let place = |places: &[Option<Place>], ix: i32| {
            usize::try_from(ix).ok().and_then(|ix| places.get(ix).copied().flatten())
        };
        for crease in &self.tags.creases {
            let Some(part) = crease.vertices.iter().find_map(|v| place(vertices, *v)).map(|p| p.part) else {
                continue;
            };
            let within = |v: &i32| place(vertices, *v).filter(|p| p.part == part).map_or(-1, |p| p.ix);
            let chain = crease.vertices.iter().map(within).collect();
            meshes[part].creases.push(Crease { vertices: chain, sharpness: crease.sharpness.clone() });
        }
        for (vertex, sharpness) in &self.tags.corners {
            if let Some(Place { part, ix }) = place(vertices, *vertex) {
                meshes[part].corners.push((ix, *sharpness));
            }
        }
        for hole in &self.tags.holes {
            if let Some(Place { part, ix }) = place(faces, *hole) {
                meshes[part].holes.push(ix);
            }
        }
    }

    fn part(&self, groups: &[usize], mesh: SubdivisionMesh) -> Part {
        let mut names: Vec<&str> = groups.iter().map(|g| self.groups[*g].name.as_str()).collect();
        names.retain(|name| !name.is_empty());
        names.dedup();
        let name = match names.as_slice() {
            [] => String::new(),
            all if all.len() <= 3 => all.join(", "),
            [first, others @ ..] => format!("{first} and {} others", others.len()),
        };
        let line = groups.first().map_or(0, |g| self.groups[*g].line);
        Part { name, line, mesh }
    }

    /// The file's rules, which hold for all of its faces.
    pub(super) fn rules(&self, mesh: SubdivisionMesh) -> SubdivisionMesh {
        SubdivisionMesh {
            boundary: self.tags.boundary,
            face_varying: self.tags.face_varying(),
            crease_method: self.tags.crease_method,
            ..mesh
        }
    }

    pub(super) fn texcoord(&self, corner: &Corner) -> Option<[f32; 2]> {
        self.texcoords.get(usize::try_from(corner.texcoord).ok()?).copied()
    }
}

/// Texture coordinates of all corners as a variable; `None` where there is no corner.
pub(super) fn st_var(values: Vec<f32>) -> Option<PrimVar> {
    (!values.is_empty()).then(|| PrimVar {
        name: "st".to_string(),
        class: Class::FaceVarying,
        ty: VarType::Float,
        array_len: 2,
        values: VarValues::Floats(values.into()),
    })
}

/// The lowest group that `group` hangs together with, by links that are shortened on the way.
fn root(parent: &mut [usize], mut group: usize) -> usize {
    while parent[group] != group {
        parent[group] = parent[parent[group]];
        group = parent[group];
    }
    group
}
