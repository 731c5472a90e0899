#include "hardware/still/gphoto_body.h"

#include <fmt/format.h>
#include <gphoto2/gphoto2-abilities-list.h>
#include <gphoto2/gphoto2-port-info-list.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <mutex>
#include <utility>

#include "hardware/transport/transcript.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

// libtool, which loads libgphoto2's drivers, is not made for threads.
std::mutex loading;

template <class T>
using Freed = std::unique_ptr<T, int (*)(T*)>;

struct Drivers {
  CameraAbilitiesList* abilities = nullptr;  // kept: loading takes a quarter of a second
  Freed<GPPortInfoList> ports{nullptr, gp_port_info_list_free};
};

void require_library(int result, const char* doing) {
  if (result < 0)
    throw DeviceError(Kind::kFault,
                      fmt::format("libgphoto2 cannot {} ({})", doing, gp_result_as_string(result)),
                      "install libgphoto2 again");
}

Drivers load_drivers(GPContext* context) {
  static Freed<CameraAbilitiesList> known{nullptr, gp_abilities_list_free};
  if (!known) {
    CameraAbilitiesList* list = nullptr;
    require_library(gp_abilities_list_new(&list), "list its drivers");
    Freed<CameraAbilitiesList> owner(list, gp_abilities_list_free);
    require_library(gp_abilities_list_load(list, context), "load its drivers");
    known = std::move(owner);
  }
  Drivers out;
  out.abilities = known.get();
  GPPortInfoList* ports = nullptr;
  require_library(gp_port_info_list_new(&ports), "list the ports");
  out.ports.reset(ports);
  require_library(gp_port_info_list_load(ports), "list the ports");
  return out;
}

/// "usb:001,005": bus and device.
std::pair<int, int> place_of(const std::string& address) {
  int bus = 0, device = 0;
  std::sscanf(address.c_str(), "usb:%d,%d", &bus, &device);
  return {bus, device};
}

/// Transfers fail before the system notices that a cable is out.
bool is_gone(const std::string& address, bool soon) {
  const SteadyClock clock;
  const Deadline end = clock.in(Duration::of(soon ? 0.15 : 0));
  while (plugged_in(address)) {
    if (clock.now_ns() >= end.at_ns) return false;
    SteadyClock().wait_until(clock.now_ns() + 5'000'000);
  }
  return true;
}

}  // namespace

bool plugged_in(const std::string& address) {
  constexpr int kUsbMajor = 189, kDevicesPerBus = 128;
  const auto [bus, device] = place_of(address);
  return std::filesystem::exists(
      fmt::format("/sys/dev/char/{}:{}", kUsbMajor, (bus - 1) * kDevicesPerBus + device - 1));
}

std::vector<GphotoPort> gphoto_ports() {
  const std::lock_guard lock(loading);
  const std::unique_ptr<GPContext, void (*)(GPContext*)> context(gp_context_new(),
                                                                 gp_context_unref);
  const Drivers drivers = load_drivers(context.get());
  CameraList* found = nullptr;
  require_library(gp_list_new(&found), "list cameras");
  const Freed<CameraList> owner(found, gp_list_free);
  require_library(
      gp_abilities_list_detect(drivers.abilities, drivers.ports.get(), found, context.get()),
      "look for cameras");
  std::vector<GphotoPort> out;
  for (int i = 0; i < gp_list_count(found); ++i) {
    const char *model = nullptr, *address = nullptr;
    gp_list_get_name(found, i, &model);
    gp_list_get_value(found, i, &address);
    if (!std::string(address).starts_with("usb:")) continue;
    CameraAbilities abilities{};
    const int driver = gp_abilities_list_lookup_model(drivers.abilities, model);
    const bool known = gp_abilities_list_get_abilities(drivers.abilities, driver, &abilities) >= 0;
    out.push_back({model, address, known && (abilities.operations & GP_OPERATION_CAPTURE_IMAGE)});
  }
  return out;
}

void GphotoBody::Deleter::operator()(GPContext* context) const {
  gp_context_unref(context);
}
void GphotoBody::Deleter::operator()(Camera* camera) const {
  gp_camera_unref(camera);
}
void GphotoBody::Deleter::operator()(CameraWidget* widget) const {
  gp_widget_free(widget);
}

GphotoBody::GphotoBody(const GphotoPort& port, Duration usb_patience)
    : port_(port), context_(gp_context_new()) {
  gp_context_set_error_func(
      context_.get(),
      [](GPContext*, const char* text, void* self) {
        static_cast<GphotoBody*>(self)->said_ = printable(text);
      },
      this);
  gp_context_set_cancel_func(
      context_.get(),
      [](GPContext*, void* self) {
        return static_cast<GphotoBody*>(self)->stop_.stop_requested() ? GP_CONTEXT_FEEDBACK_CANCEL
                                                                      : GP_CONTEXT_FEEDBACK_OK;
      },
      this);
  const auto [bus, device] = place_of(port.address);
  const std::string node = fmt::format("/dev/bus/usb/{:03}/{:03}", bus, device);
  if (::access(node.c_str(), R_OK | W_OK) != 0 && errno == EACCES)
    throw DeviceError(Kind::kPermission, "the camera at " + port.address + " may not be opened",
                      "install the udev rules, plug it in again");
  {
    const std::lock_guard lock(loading);
    const Drivers drivers = load_drivers(context_.get());
    Camera* camera = nullptr;
    require(gp_camera_new(&camera), "be opened");
    camera_.reset(camera);
    CameraAbilities abilities{};
    const int driver = gp_abilities_list_lookup_model(drivers.abilities, port.model.c_str());
    require(gp_abilities_list_get_abilities(drivers.abilities, driver, &abilities), "be opened");
    require(gp_camera_set_abilities(camera, abilities), "be opened");
    const int at = gp_port_info_list_lookup_path(drivers.ports.get(), port.address.c_str());
    GPPortInfo info{};
    require(gp_port_info_list_get_info(drivers.ports.get(), at, &info), "be opened");
    require(gp_camera_set_port_info(camera, info), "be opened");
  }
  require(gp_camera_init(camera_.get(), context_.get()), "be opened");
  require(gp_port_set_timeout(camera_->port, static_cast<int>(1000 * usb_patience.value())),
          "be opened");
  patience_ns_ = static_cast<Nanoseconds>(usb_patience.value() * 1e9);
}

GphotoBody::~GphotoBody() {
  gp_camera_exit(camera_.get(), context_.get());
}

void GphotoBody::require(int result, const std::string& doing) {
  if (result < 0) fail(result, doing);
  said_.clear();
}

void GphotoBody::fail(int result, const std::string& doing) {
  const std::string reason = said_.empty() ? gp_result_as_string(result) : std::exchange(said_, {});
  const std::string problem =
      fmt::format("the camera at {} cannot {} ({}, {})", port_.address, doing, reason, result);
  if (result == GP_ERROR_IO_USB_FIND || is_gone(port_.address, result == GP_ERROR_IO))
    throw DeviceError(Kind::kDisconnected, problem + ": it is gone",
                      "plug it in again, then run the command again");
  // A time-out within a transaction comes as an error of input or output.
  if (result == GP_ERROR_IO && SteadyClock().now_ns() - began_ns_ >= patience_ns_)
    result = GP_ERROR_TIMEOUT;
  switch (result) {
    case GP_ERROR_CANCEL:
      throw Cancelled("the camera was asked to stop");
    case GP_ERROR:  // it answered that it will not
      throw DeviceError(Kind::kRefused, problem, "see what it says on its screen");
    case GP_ERROR_TIMEOUT:
      throw DeviceError(Kind::kTimeout, problem, "see that it is on and awake");
    case GP_ERROR_IO_USB_CLAIM:
    case GP_ERROR_IO_LOCK:
      throw DeviceError(Kind::kBusy, problem,
                        "end the program that has it; a desktop may open cameras by itself");
    case GP_ERROR_NO_SPACE:
      throw DeviceError(Kind::kRefused, problem, "empty its card");
    case GP_ERROR_CAMERA_BUSY:
    case GP_ERROR_NOT_SUPPORTED:
    case GP_ERROR_CAMERA_ERROR:
      throw DeviceError(Kind::kRefused, problem, "see what it says on its screen");
    default:
      throw DeviceError(Kind::kProtocol, problem, "switch it off and on, then run it again");
  }
}

GphotoBody::Widget GphotoBody::widget(const std::string& setting) {
  CameraWidget* out = nullptr;
  begin();
  require(gp_camera_get_single_config(camera_.get(), setting.c_str(), &out, context_.get()),
          "say its " + setting);
  return Widget(out);
}

bool GphotoBody::has(const std::string& setting) {
  begin();
  CameraWidget* out = nullptr;
  const int result =
      gp_camera_get_single_config(camera_.get(), setting.c_str(), &out, context_.get());
  if (out) gp_widget_free(out);
  if (result != GP_ERROR_BAD_PARAMETERS) require(result, "say its " + setting);
  said_.clear();
  return result >= 0;
}

std::string GphotoBody::value(const std::string& setting) {
  const Widget w = widget(setting);
  const char* text = nullptr;
  require(gp_widget_get_value(w.get(), &text), "say its " + setting);
  return text ? printable(text) : "";
}

std::vector<std::string> GphotoBody::choices(const std::string& setting) {
  const Widget w = widget(setting);
  std::vector<std::string> out;
  for (int i = 0; i < gp_widget_count_choices(w.get()); ++i) {
    const char* text = nullptr;
    require(gp_widget_get_choice(w.get(), i, &text), "say its choices of " + setting);
    out.emplace_back(text);
  }
  return out;
}

void GphotoBody::set(const std::string& setting, const std::string& value) {
  const Widget w = widget(setting);
  begin();
  require(gp_widget_set_value(w.get(), value.c_str()), "set its " + setting + " to " + value);
  int result = gp_camera_set_single_config(camera_.get(), setting.c_str(), w.get(), context_.get());
  if (result == GP_ERROR_BAD_PARAMETERS) result = GP_ERROR;  // the body does not take it
  require(result, "set its " + setting + " to " + value);
}

void GphotoBody::trigger() {
  begin();
  const int result = gp_camera_trigger_capture(camera_.get(), context_.get());
  if (result == GP_ERROR && card_is_full())
    throw DeviceError(Kind::kRefused, "the camera's card is full", "empty it");
  require(result, "take a picture");
}

void GphotoBody::require_plugged_in() {
  if (!plugged_in(port_.address)) fail(GP_ERROR_IO_USB_FIND, "be reached");
}

bool GphotoBody::card_is_full() {
  CameraStorageInformation* storages = nullptr;
  int count = 0;
  if (gp_camera_get_storageinfo(camera_.get(), &storages, &count, context_.get()) < 0) return false;
  const std::unique_ptr<CameraStorageInformation, void (*)(void*)> owner(storages, std::free);
  return std::any_of(storages, storages + count, [](const CameraStorageInformation& s) {
    return s.fields & GP_STORAGEINFO_FREESPACEKBYTES && s.freekbytes == 0;
  });
}

std::optional<CameraFilePath> GphotoBody::next_picture(Duration limit) {
  const SteadyClock clock;
  const Deadline end = clock.in(limit);
  do {
    const auto left_ms = static_cast<int>((end.at_ns - clock.now_ns()) / 1'000'000);
    CameraEventType type = GP_EVENT_UNKNOWN;
    begin();
    void* data = nullptr;
    const int result =
        gp_camera_wait_for_event(camera_.get(), std::max(left_ms, 1), &type, &data, context_.get());
    const std::unique_ptr<void, void (*)(void*)> owner(data, std::free);
    require(result, "say what it does");
    if (type == GP_EVENT_FILE_ADDED) return *static_cast<const CameraFilePath*>(data);
    if (type == GP_EVENT_TIMEOUT) break;
  } while (clock.now_ns() < end.at_ns && !stop_.stop_requested());
  return std::nullopt;
}

std::vector<std::byte> GphotoBody::fetch(const CameraFilePath& path) {
  begin();
  CameraFile* file = nullptr;
  require(gp_file_new(&file), "hand over its picture");
  const Freed<CameraFile> owner(file, gp_file_unref);
  require(gp_camera_file_get(camera_.get(), path.folder, path.name, GP_FILE_TYPE_NORMAL, file,
                             context_.get()),
          "hand over its picture");
  const char* data = nullptr;
  unsigned long size = 0;
  require(gp_file_get_data_and_size(file, &data, &size), "hand over its picture");
  const auto* bytes = reinterpret_cast<const std::byte*>(data);
  return {bytes, bytes + size};
}

void GphotoBody::remove(const CameraFilePath& path) {
  begin();
  // A picture that went straight to the host lies outside of every store of the card.
  if (std::string(path.folder).starts_with("/store_"))
    require(gp_camera_file_delete(camera_.get(), path.folder, path.name, context_.get()),
            "delete its picture");
  require(gp_filesystem_reset(camera_->fs), "forget its picture");
}

}  // namespace wheatstone
