#pragma once

namespace wheatstone {

/// For programs that make and drop picture-sized buffers all the time: freed memory stays with the
/// process instead of going back to the system, whose fresh pages cost more time than most of what
/// is done to them. To be called first thing in main().
void keep_freed_memory();

}  // namespace wheatstone
