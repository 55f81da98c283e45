//! Types that Rust and WGSL share, and the macro that declares structures of them.

/// A type with the same meaning in both languages. Offsets follow WGSL's alignment rules.
pub trait GpuType {
    /// Alignment of its values, in bytes.
    const ALIGN: usize;
    /// Size, in bytes.
    const SIZE: usize;
    /// Returns its name in WGSL.
    fn wgsl() -> String;
    /// Appends its little-endian bytes to `bytes`.
    fn put(&self, bytes: &mut Vec<u8>);
}

/// `array<T, N>`. In a uniform, the element size must be a multiple of 16 bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Array<T, const N: usize>(pub [T; N]);

macro_rules! scalar {
    ($scalar:ident) => {
        impl GpuType for $scalar {
            const ALIGN: usize = 4;
            const SIZE: usize = 4;
            fn wgsl() -> String {
                stringify!($scalar).to_owned()
            }
            fn put(&self, bytes: &mut Vec<u8>) {
                bytes.extend(self.to_le_bytes());
            }
        }
        vector!($scalar, 2, 8);
        vector!($scalar, 3, 16);
        vector!($scalar, 4, 16);
    };
}

macro_rules! vector {
    ($scalar:ident, $count:literal, $align:literal) => {
        impl GpuType for [$scalar; $count] {
            const ALIGN: usize = $align;
            const SIZE: usize = 4 * $count;
            fn wgsl() -> String {
                concat!("vec", $count, "<", stringify!($scalar), ">").to_owned()
            }
            fn put(&self, bytes: &mut Vec<u8>) {
                self.iter().for_each(|c| bytes.extend(c.to_le_bytes()));
            }
        }
    };
}

scalar!(f32);
scalar!(i32);
scalar!(u32);

impl GpuType for [[f32; 4]; 4] {
    const ALIGN: usize = 16;
    const SIZE: usize = 64;
    fn wgsl() -> String {
        "mat4x4<f32>".to_owned()
    }
    fn put(&self, bytes: &mut Vec<u8>) {
        self.iter().for_each(|column| column.put(bytes));
    }
}

impl<T: GpuType, const N: usize> GpuType for Array<T, N> {
    const ALIGN: usize = T::ALIGN;
    const SIZE: usize = T::SIZE.next_multiple_of(T::ALIGN) * N;
    fn wgsl() -> String {
        format!("array<{}, {N}>", T::wgsl())
    }
    fn put(&self, bytes: &mut Vec<u8>) {
        let start = bytes.len();
        for element in &self.0 {
            pad(bytes, start, T::ALIGN);
            element.put(bytes);
        }
        pad(bytes, start, T::ALIGN);
    }
}

/// Appends zeros until the length from `start` on is a multiple of `align` bytes.
pub fn pad(bytes: &mut Vec<u8>, start: usize, align: usize) {
    bytes.resize(start + (bytes.len() - start).next_multiple_of(align), 0);
}

/// Alignment of every structure, so that each may be a uniform, a member of one, or an array element in one.
pub const STRUCT_ALIGN: usize = 16;

/// Returns the WGSL declaration of a structure with members of the given names, alignments and types. The
/// first member carries the structure's alignment. For members that are themselves structures of smaller
/// members, naga needs an explicit alignment.
pub fn declaration(name: &str, members: &[(&str, usize, String)]) -> String {
    let mut text = format!("struct {name} {{\n");
    for (i, (member, align, kind)) in members.iter().enumerate() {
        let attribute = if i == 0 || *align == STRUCT_ALIGN { "@align(16) " } else { "" };
        text += &format!("    {attribute}{member}: {kind},\n");
    }
    text + "}\n\n"
}

/// Declares a structure in Rust and WGSL at once. Rust writes the padding that WGSL's alignment rules
/// require. A crate that has its own shaders adds the declarations to its text.
#[macro_export]
macro_rules! gpu_struct {
    ($(#[$doc:meta])* pub struct $name:ident { $($(#[$field_doc:meta])* pub $field:ident: $kind:ty,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name { $($(#[$field_doc])* pub $field: $kind,)* }

        impl $name {
            /// The structure's WGSL declaration, and the offsets at which Rust writes its fields.
            pub const INFO: $crate::layout::StructInfo = $crate::layout::StructInfo {
                name: concat!("Adumbra", stringify!($name)),
                size: <Self as $crate::layout::GpuType>::SIZE,
                fields: || {
                    let mut end = 0_usize;
                    let mut offset = |align: usize, size: usize| {
                        let offset = end.next_multiple_of(align);
                        end = offset + size;
                        offset
                    };
                    vec![$((
                        stringify!($field),
                        offset(
                            <$kind as $crate::layout::GpuType>::ALIGN,
                            <$kind as $crate::layout::GpuType>::SIZE,
                        ),
                    ),)*]
                },
                declare: || {
                    let members = [$((
                        stringify!($field),
                        <$kind as $crate::layout::GpuType>::ALIGN,
                        <$kind as $crate::layout::GpuType>::wgsl(),
                    ),)*];
                    $crate::layout::kinds::declaration(concat!("Adumbra", stringify!($name)), &members)
                },
            };

            /// Returns its bytes as a uniform or storage buffer holds them.
            pub fn bytes(&self) -> Vec<u8> {
                let mut bytes = Vec::with_capacity(<Self as $crate::layout::GpuType>::SIZE);
                $crate::layout::GpuType::put(self, &mut bytes);
                bytes
            }
        }

        impl $crate::layout::GpuType for $name {
            const ALIGN: usize = $crate::layout::kinds::STRUCT_ALIGN;
            const SIZE: usize = {
                let end = 0_usize;
                $(
                    let end = end.next_multiple_of(<$kind as $crate::layout::GpuType>::ALIGN)
                        + <$kind as $crate::layout::GpuType>::SIZE;
                )*
                end.next_multiple_of(<Self as $crate::layout::GpuType>::ALIGN)
            };
            fn wgsl() -> String {
                concat!("Adumbra", stringify!($name)).to_owned()
            }
            fn put(&self, bytes: &mut Vec<u8>) {
                let start = bytes.len();
                $(
                    $crate::layout::kinds::pad(bytes, start, <$kind as $crate::layout::GpuType>::ALIGN);
                    $crate::layout::GpuType::put(&self.$field, bytes);
                )*
                $crate::layout::kinds::pad(bytes, start, <Self as $crate::layout::GpuType>::ALIGN);
            }
        }
    };
}
