//! Runs a function with bounds on its memory and its stack.
//!
//! minijinja counts instructions, but one instruction may double a text, or print a value that holds itself. Rust ends the
//! process when an allocation fails and when the stack is full. The function therefore runs in a thread of its own; when
//! it passes a bound the thread stops for good with all that it holds, and the caller goes on.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::panic::{self, catch_unwind, AssertUnwindSafe};
use std::ptr::null;
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Arc, Once};
use std::thread::{self, Thread};

/// Nested values are freed by a recursion over their depth: room for the deepest that 64 MB can hold. Only what is used
/// of a stack takes memory.
const STACK_BYTES: usize = 256 << 20;
/// What may be used of the stack where its use is checked. A text that is made meanwhile grows by doubling, so that the
/// recursion that makes it gets at most twice as deep until the next check.
const CHECKED_STACK_BYTES: usize = STACK_BYTES / 4;

pub enum Stop {
    Memory,
    Stack,
    Panic(String),
}

const RUNS: u8 = 0;
const ENDED: u8 = 1;
const NO_MEMORY: u8 = 2;
const NO_STACK: u8 = 3;

struct Shared {
    state: AtomicU8,
    caller: Thread,
}

impl Shared {
    fn report(&self, state: u8) {
        self.state.store(state, Ordering::Release);
        self.caller.unpark();
    }
}

thread_local! {
    static LEFT: Cell<isize> = const { Cell::new(isize::MAX) };
    static BOUNDED: Cell<*const Shared> = const { Cell::new(null()) };
    static STACK_TOP: Cell<usize> = const { Cell::new(0) };
}

pub fn run<T: Send + 'static>(bytes: usize, function: impl FnOnce() -> T + Send + 'static) -> Result<T, Stop> {
    static QUIET: Once = Once::new();
    QUIET.call_once(|| panic::set_hook(Box::new(|_| {})));
    let shared = Arc::new(Shared { state: AtomicU8::new(RUNS), caller: thread::current() });
    let inside = shared.clone();
    let body = move || {
        LEFT.set(bytes as isize);
        STACK_TOP.set(stack_place());
        BOUNDED.set(Arc::as_ptr(&inside));
        let result = catch_unwind(AssertUnwindSafe(function));
        BOUNDED.set(null());
        inside.report(ENDED);
        result
    };
    let worker = match thread::Builder::new().stack_size(STACK_BYTES).spawn(body) {
        Ok(worker) => worker,
        Err(error) => return Err(Stop::Panic(format!("no thread could be started: {error}"))),
    };
    while shared.state.load(Ordering::Acquire) == RUNS {
        thread::park();
    }
    match shared.state.load(Ordering::Acquire) {
        NO_MEMORY => return Err(Stop::Memory),
        NO_STACK => return Err(Stop::Stack),
        _ => (),
    }
    match worker.join() {
        Ok(Ok(result)) => Ok(result),
        Ok(Err(panic)) | Err(panic) => {
            let text = panic.downcast_ref::<&str>().map(|text| text.to_string());
            Err(Stop::Panic(text.or(panic.downcast_ref::<String>().cloned()).unwrap_or_default()))
        }
    }
}

/// The allocator of all Rust code in this library.
#[global_allocator]
static COUNTING: Counting = Counting;

struct Counting;

fn take(bytes: usize) {
    LEFT.set(LEFT.get().wrapping_sub(bytes as isize));
    if LEFT.get() < 0 {
        stop(NO_MEMORY);
    }
    check_stack();
}

/// An address near the end of the stack.
#[inline(never)]
fn stack_place() -> usize {
    let here = 0u8;
    std::hint::black_box(&here) as *const u8 as usize
}

pub fn check_stack() {
    if STACK_TOP.get().saturating_sub(stack_place()) > CHECKED_STACK_BYTES {
        stop(NO_STACK);
    }
}

/// Ends the function that runs here; does nothing in other threads.
fn stop(state: u8) {
    if let Some(shared) = unsafe { BOUNDED.get().as_ref() } {
        shared.report(state);
        loop {
            thread::park();
        }
    }
}

fn give(bytes: usize) {
    LEFT.set(LEFT.get().wrapping_add(bytes as isize));
}

unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        take(layout.size());
        System.alloc(layout)
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        take(layout.size());
        System.alloc_zeroed(layout)
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        give(layout.size());
        System.dealloc(place, layout)
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        take(size);
        give(layout.size());
        System.realloc(place, layout, size)
    }
}
