//! Types that Rust and WGSL both have, and the macro that declares structures of them.

/// A type with one meaning in both languages.
pub trait GpuType {
    /// Bytes.
    const SIZE: usize;
    /// Its name in WGSL.
    fn wgsl() -> String;
    /// Appends its little-endian bytes.
    fn put(&self, bytes: &mut Vec<u8>);
}

/// `array<T, N>` of structures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Array<T, const N: usize>(pub [T; N]);

macro_rules! vector {
    ($scalar:ty, $wgsl:literal) => {
        impl GpuType for [$scalar; 4] {
            const SIZE: usize = 16;
            fn wgsl() -> String {
                concat!("vec4<", $wgsl, ">").to_owned()
            }
            fn put(&self, bytes: &mut Vec<u8>) {
                self.iter().for_each(|c| bytes.extend(c.to_le_bytes()));
            }
        }
    };
}
vector!(f32, "f32");
vector!(i32, "i32");
vector!(u32, "u32");

impl GpuType for [[f32; 4]; 4] {
    const SIZE: usize = 64;
    fn wgsl() -> String {
        "mat4x4<f32>".to_owned()
    }
    fn put(&self, bytes: &mut Vec<u8>) {
        self.iter().for_each(|column| column.put(bytes));
    }
}

impl<T: GpuType, const N: usize> GpuType for Array<T, N> {
    const SIZE: usize = T::SIZE * N;
    fn wgsl() -> String {
        format!("array<{}, {N}>", T::wgsl())
    }
    fn put(&self, bytes: &mut Vec<u8>) {
        self.0.iter().for_each(|t| t.put(bytes));
    }
}

/// Declares a structure for Rust and WGSL at once.
macro_rules! gpu_struct {
    ($(#[$doc:meta])* pub struct $name:ident { $($(#[$field_doc:meta])* pub $field:ident: $kind:ty,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name { $($(#[$field_doc])* pub $field: $kind,)* }

        impl $name {
            /// For the test against naga.
            pub const INFO: $crate::layout::StructInfo = $crate::layout::StructInfo {
                name: stringify!($name),
                size: <Self as $crate::layout::GpuType>::SIZE,
                fields: || {
                    let mut end = 0;
                    let mut place = |size: usize| {
                        end += size;
                        end - size
                    };
                    vec![$((stringify!($field), place(<$kind as $crate::layout::GpuType>::SIZE)),)*]
                },
                declare: || {
                    let mut text = concat!("struct ", stringify!($name), " {\n").to_owned();
                    $(
                        text += &format!("    {}: {},\n", stringify!($field), <$kind as $crate::layout::GpuType>::wgsl());
                    )*
                    text + "}\n\n"
                },
            };

            /// Its bytes, as a uniform or storage buffer holds them.
            pub fn bytes(&self) -> Vec<u8> {
                let mut bytes = Vec::with_capacity(<Self as $crate::layout::GpuType>::SIZE);
                $crate::layout::GpuType::put(self, &mut bytes);
                bytes
            }
        }

        impl $crate::layout::GpuType for $name {
            const SIZE: usize = 0 $(+ <$kind as $crate::layout::GpuType>::SIZE)*;
            fn wgsl() -> String {
                stringify!($name).to_owned()
            }
            fn put(&self, bytes: &mut Vec<u8>) {
                $($crate::layout::GpuType::put(&self.$field, bytes);)*
            }
        }
    };
}

pub(super) use gpu_struct;
