#pragma once
// How pictures come over from the kernel.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/clock.h"
#include "hardware/video/v4l2_node.h"

namespace wheatstone {

enum class V4l2Transfer { kMmap, kUserPointer, kRead };

/// A picture that came over. Its bytes are the camera's again with give_back().
struct V4l2Filled {
  std::span<const std::uint8_t> bytes;
  std::uint32_t index = 0, sequence = 0, flags = 0;
  Nanoseconds stamp_ns = 0;
  bool failed = false;  // EIO: the stream must be started again
};

/// The ring of buffers of one stream; the node keeps them from construction to destruction.
class V4l2Buffers {
 public:
  /// Asks for `count` buffers; takes what is granted. Throws kRefused if that is none.
  V4l2Buffers(V4l2Node&, V4l2Transfer, std::size_t bytes, int count, const Deadline&);
  ~V4l2Buffers();
  V4l2Buffers(const V4l2Buffers&) = delete;
  V4l2Buffers& operator=(const V4l2Buffers&) = delete;

  /// All buffers to the camera, then stream on.
  void start(const Deadline&);
  /// Any thread; the camera drops what it has. Reading ends with the node.
  void stop() noexcept;
  /// None: nothing has come yet. Throws kProtocol for a buffer that does not exist.
  std::optional<V4l2Filled> take();
  void give_back(std::uint32_t index, const Deadline&);

 private:
  struct Memory {
    std::uint8_t* data = nullptr;
    std::size_t size = 0;
  };

  std::optional<V4l2Filled> read();
  void map(std::uint32_t index, const Deadline&);
  void release() noexcept;

  V4l2Node& node_;
  V4l2Transfer transfer_;
  std::vector<Memory> memory_;
  std::uint32_t reads_ = 0;
};

}  // namespace wheatstone
