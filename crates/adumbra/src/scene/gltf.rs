//! s
use super::*;
fn mul(a: &[[f64;4];3], b: &[[f64;4];3]) -> [[f64;4];3] {
  let mut r=[[0.0;4];3]; for i in 0..3 { for j in 0..4 { r[i][j] = (0..3).map(|k| a[i][k]*b[k][j]).sum::<f64>() + if j==3 {a[i][3]} else {0.0}; } } r }
fn walk(n: ::gltf::Node<'_>, m: [[f64;4];3], groups: &[Vec<u32>], s: &mut Scene) {
  let t = n.transform().matrix(); let mut l=[[0.0;4];3]; for i in 0..3 { for j in 0..4 { l[i][j]=t[j][i] as f64; } }
  let m = mul(&m,&l);
  if let Some(me)=n.mesh() { for &g in &groups[me.index()] { s.instances.push(Instance{name:String::new(),mesh:g,world_from_mesh:m,casts:true}); } }
  for c in n.children() { walk(c,m,groups,s); }
}
pub fn load(path: &Path, _o: &LoadOptions) -> Result<Scene> {
  let g = ::gltf::Gltf::from_slice_without_validation(&std::fs::read(path).unwrap()).unwrap();
  let blob = g.blob.clone().unwrap();
  let mut s = Scene { materials: vec![Material::opaque("x",[1.0;4])], ..Default::default() };
  let mut groups = vec![];
  for me in g.meshes() {
    let mut gr = vec![];
    for p in me.primitives() {
      let r = p.reader(|_| Some(&blob[..]));
      let positions: Vec<[f32;3]> = r.read_positions().unwrap().collect();
      let idx: Vec<u32> = match r.read_indices() { Some(i) => i.into_u32().collect(), None => (0..positions.len() as u32).collect() };
      let triangles: Vec<[u32;3]> = idx.chunks(3).map(|c| [c[0],c[1],c[2]]).collect();
      let one = obj::single(positions, triangles).meshes.remove(0);
      gr.push(s.meshes.len() as u32); s.meshes.push(one);
    }
    groups.push(gr);
  }
  let sc = g.default_scene().or_else(|| g.scenes().next()).unwrap();
  for n in sc.nodes() { walk(n, [[1.,0.,0.,0.],[0.,1.,0.,0.],[0.,0.,1.,0.]], &groups, &mut s); }
  Ok(s)
}
