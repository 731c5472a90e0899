#pragma once
// The tree of devices that a program sees in place of the machine's, under umockdev-wrapper.

#include <umockdev.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace wheatstone {

struct UnrefGObject {
  void operator()(void* object) const { g_object_unref(object); }
};
template <class T>
using OwnedGObject = std::unique_ptr<T, UnrefGObject>;

/// The machine's devices as the program and its children see them: none but the emulated ones. One
/// at a time in a process.
class MockBed {
 public:
  /// Throws DeviceError kNotReady unless the program was started by umockdev-wrapper.
  MockBed();
  MockBed(const MockBed&) = delete;
  MockBed& operator=(const MockBed&) = delete;

  /// `description` as umockdev_testbed_add_from_string() takes it. Throws DeviceError kFault.
  void add(const std::string& description);
  /// The devices with these paths below /sys, children before their parents.
  void remove(const std::vector<std::string>& devices);
  /// What a client asks of `node` is answered by `handler`. Throws DeviceError kFault.
  void attach(const std::string& node, UMockdevIoctlBase* handler);
  void detach(const std::string& node);
  void announce(const std::string& device, const char* action);
  /// Only root may open `node` from now on.
  void forbid(const std::string& node);

  /// Where "/dev/x" really lies.
  std::filesystem::path real_path(const std::string& node) const { return root_.string() + node; }

 private:
  OwnedGObject<UMockdevTestbed> bed_;
  std::filesystem::path root_;
};

}  // namespace wheatstone
