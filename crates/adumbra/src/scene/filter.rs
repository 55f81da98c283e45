//! stub
/// stub
#[derive(Clone, Debug, Default)]
pub struct NameFilter;
impl NameFilter{ pub fn new(_:&[String],_:&[String])->crate::Result<Self>{Ok(Self)}}