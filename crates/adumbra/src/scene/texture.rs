//! stub
/// stub
#[derive(Clone, Debug)]
pub struct Texture;
/// stub
pub enum Wrap {}
impl Texture { /// s
pub fn alpha(&self, _uv: [f32; 2]) -> f32 { 1.0 } pub(crate) fn memory_bytes(&self)->usize{0} pub fn color(&self,_:[f32;2])->[f32;4]{[1.0;4]} }
