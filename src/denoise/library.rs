//! The library's C interface, behind safe types. The only file outside `gpu` that contains `unsafe`.
//!
//! Three invariants make every public function here safe, and every `// SAFETY:` comment cites the ones that it rests on.
//!
//! 1. **The library is what it says.** A file that has the library's name and all of the functions of [`Functions`], and lies
//!    where the user or the system has put it, is trusted to be Open Image Denoise 2. Its header declares these signatures for
//!    every version 2.x. It stays loaded until the process ends, because its threads outlive its devices.
//! 2. **One owner per handle.** A handle is created by, stored in and released by exactly one value, which is neither `Copy` nor
//!    `Clone` and does not leave its thread. Handles of buffers and filters borrow their device, so the device is released last.
//! 3. **Pointers live for the call.** Pointers that are handed over point into locals or arguments of the caller with the length
//!    that is handed over beside them. The library copies what it keeps. It keeps one pointer: the list of messages, which
//!    the device's value owns on the heap and frees after the device.

#![deny(clippy::undocumented_unsafe_blocks)]

use std::ffi::{CStr, CString, OsStr, c_char, c_int, c_void};
use std::ptr;
use std::sync::{Mutex, PoisonError};

use libloading::Library;

type Handle = *mut c_void;
type ErrorFunction = extern "C" fn(*mut c_void, c_int, *const c_char);

/// `OIDN_FORMAT_FLOAT3`: three 32-bit floats.
const FLOAT3: c_int = 3;
/// Bytes of one pixel. Pixels lie one after the other, row by row from the top left, without gaps.
const PIXEL_BYTES: usize = size_of::<[f32; 3]>();

/// Declares the functions of the library and how they are found.
macro_rules! functions {
    ($($field:ident: $name:literal, fn($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// Functions of the library.
        struct Functions { $($field: unsafe extern "C" fn($($argument),*) $(-> $result)?,)* }

        impl Functions {
            fn find(library: &Library) -> Result<Self, String> {
                // SAFETY: 1. The signatures are those of the library's header.
                $(let $field = *unsafe { library.get(concat!($name, "\0").as_bytes()) }
                    .map_err(|_| format!("it lacks the function {} of version 2", $name))?;)*
                Ok(Self { $($field),* })
            }
        }
    };
}

functions! {
    physical_count: "oidnGetNumPhysicalDevices", fn() -> c_int;
    physical_int: "oidnGetPhysicalDeviceInt", fn(c_int, *const c_char) -> c_int;
    physical_text: "oidnGetPhysicalDeviceString", fn(c_int, *const c_char) -> *const c_char;
    new_device: "oidnNewDeviceByID", fn(c_int) -> Handle;
    set_error_function: "oidnSetDeviceErrorFunction", fn(Handle, ErrorFunction, *mut c_void);
    set_device_bool: "oidnSetDeviceBool", fn(Handle, *const c_char, bool);
    device_int: "oidnGetDeviceInt", fn(Handle, *const c_char) -> c_int;
    commit_device: "oidnCommitDevice", fn(Handle);
    device_error: "oidnGetDeviceError", fn(Handle, *mut *const c_char) -> c_int;
    release_device: "oidnReleaseDevice", fn(Handle);
    new_buffer: "oidnNewBuffer", fn(Handle, usize) -> Handle;
    write_buffer: "oidnWriteBuffer", fn(Handle, usize, usize, *const c_void);
    read_buffer: "oidnReadBuffer", fn(Handle, usize, usize, *mut c_void);
    release_buffer: "oidnReleaseBuffer", fn(Handle);
    new_filter: "oidnNewFilter", fn(Handle, *const c_char) -> Handle;
    set_image: "oidnSetFilterImage", fn(Handle, *const c_char, Handle, c_int, usize, usize, usize, usize, usize);
    set_filter_bool: "oidnSetFilterBool", fn(Handle, *const c_char, bool);
    commit_filter: "oidnCommitFilter", fn(Handle);
    execute_filter: "oidnExecuteFilter", fn(Handle);
    release_filter: "oidnReleaseFilter", fn(Handle);
}

/// The loaded library.
pub struct Oidn(Functions);

/// A device that the library knows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PhysicalDevice {
    /// Number by which the library knows it.
    pub id: i32,
    /// Kind of device: the number of an `OIDNDeviceType`.
    pub kind: i32,
    /// Name of the device.
    pub name: String,
}

impl Oidn {
    /// Loads the file, or the library that the system finds under this name. `None` where there is none. An error is the reason
    /// why a library that is there cannot be used.
    pub fn load(file: &OsStr) -> Option<Result<Self, String>> {
        // SAFETY: 1. The library's initializers may run.
        let library = match unsafe { Library::new(file) } {
            Ok(library) => library,
            // A bare name that the system does not find is no fault; a file that is there and cannot be loaded is one.
            Err(error) => {
                return std::path::Path::new(file).exists().then(|| Err(format!("it cannot be loaded: {error}")));
            }
        };
        let functions = Functions::find(&library);
        std::mem::forget(library);
        Some(functions.map(Self))
    }

    /// Devices of this machine, in the library's order.
    pub fn devices(&self) -> Vec<PhysicalDevice> {
        // SAFETY: 1.
        let count = unsafe { (self.0.physical_count)() };
        let device = |id| {
            // SAFETY: 1, 3. `id` is less than the number of devices.
            let kind = unsafe { (self.0.physical_int)(id, c"type".as_ptr()) };
            // SAFETY: 1, 3. The text belongs to the library and stays.
            let name = unsafe { text((self.0.physical_text)(id, c"name".as_ptr())) };
            PhysicalDevice { id, kind, name }
        };
        (0..count).map(device).collect()
    }

    /// Opens the device with this number.
    ///
    /// # Errors
    /// Reason of the library.
    pub fn open(&self, id: i32) -> Result<Device<'_>, String> {
        // SAFETY: 1. The library answers an unknown number with a null handle.
        let handle = unsafe { (self.0.new_device)(id) };
        if handle.is_null() {
            let mut message = ptr::null();
            // SAFETY: 1, 3. Without a device, the error is that of this thread; its text stays until the thread's next error.
            let reason = unsafe {
                (self.0.device_error)(ptr::null_mut(), &mut message);
                text(message)
            };
            return Err(reason);
        }
        let device = Device { functions: &self.0, handle, messages: Box::default() };
        let list: *const Mutex<Vec<String>> = &*device.messages;
        // SAFETY: 1, 2, 3. The list outlives the device. `keep_message` has the signature of the header.
        unsafe { (device.functions.set_error_function)(handle, keep_message, list.cast_mut().cast()) };
        // Another process may use the same cores, so threads are not tied to them.
        // SAFETY: 1, 2, 3.
        unsafe { (device.functions.set_device_bool)(handle, c"setAffinity".as_ptr(), false) };
        // SAFETY: 1, 2.
        unsafe { (device.functions.commit_device)(handle) };
        device.check()?;
        Ok(device)
    }
}

/// Keeps a message of the library. Nothing in it can unwind: a poisoned lock is used as it is.
extern "C" fn keep_message(list: *mut c_void, code: c_int, message: *const c_char) {
    // SAFETY: 3. The pointer is the one that `open` has handed over, and the device still exists.
    let list = unsafe { &*list.cast::<Mutex<Vec<String>>>() };
    // SAFETY: 3. The library hands over a text that is valid during this call.
    let message = unsafe { text(message) };
    list.lock().unwrap_or_else(PoisonError::into_inner).push(format!("{message} (error {code})"));
}

/// Text behind a pointer of the library; empty for a null pointer.
///
/// # Safety
/// `pointer` is null, or points to a text that ends with a zero byte and stays during the call.
unsafe fn text(pointer: *const c_char) -> String {
    if pointer.is_null() {
        return String::new();
    }
    // SAFETY: the caller's promise.
    unsafe { CStr::from_ptr(pointer) }.to_string_lossy().into_owned()
}

/// An open device.
pub struct Device<'a> {
    functions: &'a Functions,
    handle: Handle,
    /// Messages of the library about this device. They may come from any of its threads.
    messages: Box<Mutex<Vec<String>>>,
}

impl Device<'_> {
    /// Version of the library: major, minor and patch number.
    pub fn version(&self) -> [i32; 3] {
        // SAFETY: 1, 2, 3.
        let version = unsafe { (self.functions.device_int)(self.handle, c"version".as_ptr()) };
        [version / 10_000, version / 100 % 100, version % 100]
    }

    /// Copies pixels to the device.
    ///
    /// # Errors
    /// Reason of the library, such as a lack of memory.
    pub fn buffer(&self, pixels: &[[f32; 3]]) -> Result<Buffer<'_>, String> {
        let bytes = size_of_val(pixels);
        // SAFETY: 1, 2.
        let handle = unsafe { (self.functions.new_buffer)(self.handle, bytes) };
        self.check()?;
        if handle.is_null() {
            return Err(format!("it gives no buffer of {bytes} bytes"));
        }
        let buffer = Buffer { device: self, handle, pixels: pixels.len() };
        // SAFETY: 1, 2, 3. Both the buffer and the slice have `bytes` bytes.
        unsafe { (self.functions.write_buffer)(buffer.handle, 0, bytes, pixels.as_ptr().cast()) };
        self.check()?;
        Ok(buffer)
    }

    /// Makes a filter for pictures that a ray tracer has made.
    ///
    /// # Errors
    /// Reason of the library.
    pub fn filter(&self) -> Result<Filter<'_>, String> {
        // SAFETY: 1, 2, 3.
        let handle = unsafe { (self.functions.new_filter)(self.handle, c"RT".as_ptr()) };
        self.check()?;
        if handle.is_null() {
            return Err("it gives no filter for ray traced pictures".into());
        }
        Ok(Filter { device: self, handle })
    }

    /// Error where the library has sent a message.
    fn check(&self) -> Result<(), String> {
        let messages = std::mem::take(&mut *self.messages.lock().unwrap_or_else(PoisonError::into_inner));
        if messages.is_empty() { Ok(()) } else { Err(messages.join("; ")) }
    }
}

impl Drop for Device<'_> {
    fn drop(&mut self) {
        // SAFETY: 1, 2. The fields are dropped after the device.
        unsafe { (self.functions.release_device)(self.handle) };
    }
}

/// Pixels in the device's memory.
pub struct Buffer<'a> {
    device: &'a Device<'a>,
    handle: Handle,
    pixels: usize,
}

impl Buffer<'_> {
    /// Copies the pixels from the device.
    ///
    /// # Errors
    /// Reason of the library.
    pub fn read(&self) -> Result<Vec<[f32; 3]>, String> {
        let mut pixels = vec![[0.0; 3]; self.pixels];
        let bytes = size_of_val(&pixels[..]);
        // SAFETY: 1, 2, 3. Both the buffer and the vector have `bytes` bytes, and any bits are floats.
        unsafe { (self.device.functions.read_buffer)(self.handle, 0, bytes, pixels.as_mut_ptr().cast()) };
        self.device.check()?;
        Ok(pixels)
    }
}

impl Drop for Buffer<'_> {
    fn drop(&mut self) {
        // SAFETY: 1, 2. A filter that uses the buffer holds a reference of its own.
        unsafe { (self.device.functions.release_buffer)(self.handle) };
    }
}

/// A filter, of which images and switches are set before it runs.
pub struct Filter<'a> {
    device: &'a Device<'a>,
    handle: Handle,
}

impl Filter<'_> {
    /// Sets the image `name` to a buffer of `width` x `height` pixels.
    ///
    /// # Errors
    /// Where the buffer has another number of pixels or the library refuses the image.
    pub fn set_image(&self, name: &str, buffer: &Buffer<'_>, [width, height]: [usize; 2]) -> Result<(), String> {
        if width.checked_mul(height) != Some(buffer.pixels) {
            return Err(format!("the image {name} has {} pixels, not {width} x {height}", buffer.pixels));
        }
        let name = c_text(name)?;
        let row_bytes = width * PIXEL_BYTES;
        // SAFETY: 1, 2, 3. The buffer has `width * height` pixels, which lie one after the other.
        unsafe {
            (self.device.functions.set_image)(
                self.handle,
                name.as_ptr(),
                buffer.handle,
                FLOAT3,
                width,
                height,
                0,
                PIXEL_BYTES,
                row_bytes,
            );
        }
        self.device.check()
    }

    /// Turns on the switch `name`.
    ///
    /// # Errors
    /// Where the library refuses the switch.
    pub fn turn_on(&self, name: &str) -> Result<(), String> {
        let name = c_text(name)?;
        // SAFETY: 1, 2, 3.
        unsafe { (self.device.functions.set_filter_bool)(self.handle, name.as_ptr(), true) };
        self.device.check()
    }

    /// Runs the filter to its end.
    ///
    /// # Errors
    /// Reason of the library, such as a lack of memory.
    pub fn run(&self) -> Result<(), String> {
        // SAFETY: 1, 2.
        unsafe { (self.device.functions.commit_filter)(self.handle) };
        self.device.check()?;
        // SAFETY: 1, 2. The filter holds the buffers of its images.
        unsafe { (self.device.functions.execute_filter)(self.handle) };
        self.device.check()
    }
}

impl Drop for Filter<'_> {
    fn drop(&mut self) {
        // SAFETY: 1, 2.
        unsafe { (self.device.functions.release_filter)(self.handle) };
    }
}

fn c_text(name: &str) -> Result<CString, String> {
    CString::new(name).map_err(|_| format!("the name {name:?} contains a zero byte"))
}
