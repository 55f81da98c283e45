//! s
use super::*;
pub fn single(positions: Vec<[f32;3]>, triangles: Vec<[u32;3]>) -> Scene {
  let triangles: Vec<[u32;3]> = triangles.into_iter().filter(|t| t[0]!=t[1]&&t[1]!=t[2]&&t[0]!=t[2]).collect();
  let n = triangles.len();
  Scene { meshes: vec![Mesh { name: "m".into(), positions, uvs: vec![], triangles, triangle_materials: vec![0; n] }],
   instances: vec![Instance { name: "i".into(), mesh: 0, world_from_mesh: [[1.,0.,0.,0.],[0.,1.,0.,0.],[0.,0.,1.,0.]], casts: true }],
   materials: vec![Material::opaque("x",[1.0;4])], textures: vec![], notes: LoadNotes::default() }
}
pub fn load(path: &Path, _o: &LoadOptions) -> Result<Scene> {
  let (models, _) = tobj::load_obj(path, &tobj::LoadOptions { triangulate: true, single_index: true, ..Default::default() }).unwrap();
  let (mut p, mut t) = (vec![], vec![]);
  for m in models { let b = p.len() as u32; p.extend(m.mesh.positions.chunks(3).map(|c| [c[0] as f32,c[1] as f32,c[2] as f32])); t.extend(m.mesh.indices.chunks(3).map(|c| [b+c[0],b+c[1],b+c[2]])); }
  Ok(single(p,t))
}
