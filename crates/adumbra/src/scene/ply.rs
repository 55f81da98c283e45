//! s
use super::*;
pub fn load(path: &Path, _o: &LoadOptions) -> Result<Scene> {
  let d = std::fs::read(path).unwrap();
  let e = d.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
  let h = String::from_utf8_lossy(&d[..e]).to_string();
  let num = |k: &str| h.lines().find(|l| l.starts_with(k)).unwrap().split(' ').nth(2).unwrap().parse::<usize>().unwrap();
  let (v, f) = (num("element vertex"), num("element face"));
  let fl = |o: usize| f32::from_le_bytes(d[o..o+4].try_into().unwrap());
  let u = |o: usize| u32::from_le_bytes(d[o..o+4].try_into().unwrap());
  let p = (0..v).map(|i| [fl(e+i*12), fl(e+i*12+4), fl(e+i*12+8)]).collect();
  let b = e + v*12;
  let t = (0..f).map(|i| { assert_eq!(d[b+i*13],3); [u(b+i*13+1), u(b+i*13+5), u(b+i*13+9)] }).collect();
  Ok(obj::single(p,t))
}
