#include "hardware/video/v4l2_buffers.h"

#include <fmt/format.h>
#include <linux/videodev2.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <new>

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr std::size_t kPageBytes = 4096;
constexpr std::uint32_t kMostBuffers = 32;  // VIDEO_MAX_FRAME

std::uint32_t memory_type(V4l2Transfer transfer) {
  return transfer == V4l2Transfer::kMmap ? V4L2_MEMORY_MMAP : V4L2_MEMORY_USERPTR;
}

v4l2_buffer described(V4l2Transfer transfer, std::uint32_t index = 0) {
  v4l2_buffer buffer{};
  buffer.index = index;
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = memory_type(transfer);
  return buffer;
}

v4l2_requestbuffers request_for(V4l2Transfer transfer, std::uint32_t count) {
  v4l2_requestbuffers request{};
  request.count = count;
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = memory_type(transfer);
  return request;
}

std::uint8_t* pages(std::size_t bytes) {
  void* p = std::aligned_alloc(kPageBytes, (bytes + kPageBytes - 1) / kPageBytes * kPageBytes);
  if (!p) throw std::bad_alloc();
  return static_cast<std::uint8_t*>(p);
}

}  // namespace

V4l2Buffers::V4l2Buffers(V4l2Node& node, V4l2Transfer transfer, std::size_t bytes, int count,
                         const Deadline& deadline)
    : node_(node), transfer_(transfer) {
  if (transfer_ == V4l2Transfer::kRead) {
    memory_.push_back({pages(bytes), bytes});
    return;
  }
  try {
    v4l2_requestbuffers request = request_for(transfer_, static_cast<std::uint32_t>(count));
    node_.call(VIDIOC_REQBUFS, &request, "lend buffers", deadline);
    if (request.count == 0 || request.count > kMostBuffers)
      throw DeviceError(Kind::kRefused,
                        fmt::format("{} lends {} buffers", node_.what(), request.count),
                        "choose a smaller mode");
    for (std::uint32_t i = 0; i < request.count; ++i) {
      if (transfer_ == V4l2Transfer::kMmap)
        map(i, deadline);
      else
        memory_.push_back({pages(bytes), bytes});
    }
  } catch (...) {
    release();
    throw;
  }
}

V4l2Buffers::~V4l2Buffers() {
  release();
}

void V4l2Buffers::map(std::uint32_t index, const Deadline& deadline) {
  v4l2_buffer buffer = described(transfer_, index);
  node_.call(VIDIOC_QUERYBUF, &buffer, "describe its buffers", deadline);
  void* p = ::mmap(nullptr, buffer.length, PROT_READ | PROT_WRITE, MAP_SHARED, node_.handle(),
                   static_cast<off_t>(buffer.m.offset));
  if (p == MAP_FAILED) node_.fail(errno == ENODEV ? EIO : errno, "map its buffers");
  memory_.push_back({static_cast<std::uint8_t*>(p), buffer.length});
}

void V4l2Buffers::release() noexcept {
  for (const Memory& m : memory_) {
    if (transfer_ == V4l2Transfer::kMmap)
      ::munmap(m.data, m.size);
    else
      std::free(m.data);
  }
  if (transfer_ == V4l2Transfer::kRead) return;
  v4l2_requestbuffers request = request_for(transfer_, 0);
  node_.call_quietly(VIDIOC_REQBUFS, &request);
}

void V4l2Buffers::start(const Deadline& deadline) {
  if (transfer_ == V4l2Transfer::kRead) return;  // the first read() starts it
  for (std::uint32_t i = 0; i < memory_.size(); ++i) give_back(i, deadline);
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  node_.call(VIDIOC_STREAMON, &type, "start its stream", deadline);
}

void V4l2Buffers::stop() noexcept {
  if (transfer_ == V4l2Transfer::kRead) return;
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  node_.call_quietly(VIDIOC_STREAMOFF, &type);
}

void V4l2Buffers::give_back(std::uint32_t index, const Deadline& deadline) {
  if (transfer_ == V4l2Transfer::kRead) return;
  v4l2_buffer buffer = described(transfer_, index);
  if (transfer_ == V4l2Transfer::kUserPointer) {
    buffer.m.userptr = reinterpret_cast<unsigned long>(memory_[index].data);
    buffer.length = static_cast<std::uint32_t>(memory_[index].size);
  }
  node_.call(VIDIOC_QBUF, &buffer, "take a buffer back", deadline);
}

std::optional<V4l2Filled> V4l2Buffers::read() {
  node_.require_connected();
  const ssize_t n = ::read(node_.handle(), memory_[0].data, memory_[0].size);
  if (n < 0 && (errno == EAGAIN || errno == EINTR)) return {};
  if (n < 0 && errno != EIO) node_.fail(errno, "be read");
  V4l2Filled filled;
  filled.bytes = {memory_[0].data, static_cast<std::size_t>(std::max<ssize_t>(n, 0))};
  filled.sequence = reads_++;
  filled.failed = n < 0;
  return filled;
}

std::optional<V4l2Filled> V4l2Buffers::take() {
  if (transfer_ == V4l2Transfer::kRead) return read();
  node_.require_connected();
  v4l2_buffer buffer = described(transfer_);
  V4l2Filled filled;
  int error = 0;
  try {
    error = node_.ask(VIDIOC_DQBUF, &buffer, "hand out a picture");
  } catch (const DeviceError& e) {
    if (e.kind() != Kind::kFault) throw;
    filled.failed = true;
    return filled;
  }
  if (error == EAGAIN) return {};
  if (error != 0) node_.fail(error, "hand out a picture");
  if (buffer.index >= memory_.size())
    throw DeviceError(
        Kind::kProtocol,
        fmt::format("{} hands out buffer {} of {}", node_.what(), buffer.index, memory_.size()),
        "update its kernel driver");
  const Memory& m = memory_[buffer.index];
  filled.bytes = {m.data, std::min<std::size_t>(buffer.bytesused, m.size)};
  filled.index = buffer.index;
  filled.sequence = buffer.sequence;
  filled.flags = buffer.flags;
  filled.stamp_ns = static_cast<Nanoseconds>(buffer.timestamp.tv_sec) * 1'000'000'000 +
                    static_cast<Nanoseconds>(buffer.timestamp.tv_usec) * 1000;
  return filled;
}

}  // namespace wheatstone
