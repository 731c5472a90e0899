#include "hardware/argyll/spotread.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "core/error.h"
#include "core/files.h"
#include "hardware/argyll/spotread_output.h"
#include "hardware/transport/child_process.h"
#include "hardware/transport/transcript.h"

namespace wheatstone {
namespace {

namespace fs = std::filesystem;
using Kind = DeviceError::Kind;

constexpr std::size_t kLargestSpectrum = 1'000'000;

bool can_run(const fs::path& file) {
  return fs::is_regular_file(file) && ::access(file.c_str(), X_OK) == 0;
}

void require_program(const std::string& program) {
  bool found = can_run(program) && program.find('/') != std::string::npos;
  if (program.find('/') == std::string::npos) {
    const char* path = std::getenv("PATH");
    std::istringstream folders(path ? path : "");
    for (std::string folder; !found && std::getline(folders, folder, ':');)
      found = can_run(fs::path(folder) / program);
  }
  if (!found)
    throw DeviceError(Kind::kNotFound, fmt::format("there is no program {}", program),
                      "install ArgyllCMS, or correct its path in the rig file");
}

/// Removed with what is in it.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (fs::temp_directory_path() / "wheatstone-spotread-XXXXXX").string();
    if (!::mkdtemp(name.data()))
      throw FileError(fs::temp_directory_path(), "no folder can be made in it",
                      "make room, or set TMPDIR");
    path_ = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

std::string last_line(const std::string& text) {
  std::istringstream lines(text);
  std::string last;
  for (std::string line; std::getline(lines, line);)
    if (line.find_first_not_of(" \t\r") != std::string::npos) last = line;
  return last.empty() ? "nothing" : printable(last.substr(0, 120));
}

}  // namespace

Spotread::Spotread(const SpotreadSettings& settings) : settings_(settings) {
  require_program(settings.program);
  identity_ = {"spotread", "ArgyllCMS instrument", "", "",
               fmt::format("{} -c {}", settings.program, settings.port)};
  range_.floor_cd_m2 = settings.floor_cd_m2;
  range_.longest_integration = Settings().longest_integration;
}

void Spotread::configure(const Settings& settings, Deadline) {
  require_valid(settings, range_.longest_integration);
  if (settings.longest_integration != Settings().longest_integration ||
      settings.synchronise_to != Settings().synchronise_to)
    throw DeviceError(Kind::kOutOfRange, "spotread chooses its integration itself",
                      "leave the integration and the period as they are");
  average_ = settings.average;
}

void Spotread::aim(bool on, Deadline) {
  if (on)
    throw DeviceError(Kind::kRefused, "spotread has no aiming light that could be switched",
                      "use the instrument's own button");
}

void Spotread::abort() noexcept {
  const std::lock_guard lock(mutex_);
  stop_.request_stop();
}

SpectralReading Spotread::measure(Deadline deadline) {
  {
    const std::lock_guard lock(mutex_);
    stop_ = {};
  }
  const std::stop_callback forward(deadline.cancel, [this] { abort(); });
  const Deadline stoppable{deadline.at_ns, stop_.get_token()};
  SpectralReading mean = measure_once(stoppable);
  for (int i = 1; i < average_; ++i) {
    const SpectralReading next = measure_once(stoppable);
    if (next.spectrum.values.size() != mean.spectrum.values.size())
      throw DeviceError(Kind::kFault, "spotread changed its wavelengths between two readings",
                        "measure again");
    for (std::size_t k = 0; k < next.spectrum.values.size(); ++k)
      mean.spectrum.values[k] += next.spectrum.values[k];
    *mean.device_xyz_cd_m2 += *next.device_xyz_cd_m2;
  }
  for (double& v : mean.spectrum.values) v /= average_;
  *mean.device_xyz_cd_m2 /= average_;
  mean.xyz_cd_m2 = wheatstone::xyz_cd_m2(mean.spectrum);
  mean.below_floor = mean.xyz_cd_m2.y() < range_.floor_cd_m2;
  if (!mean.below_floor && !agree(mean.xyz_cd_m2, *mean.device_xyz_cd_m2))
    throw DeviceError(Kind::kFault,
                      fmt::format("the spectrum of spotread gives {:.6g} cd/m^2, itself it says "
                                  "{:.6g}",
                                  mean.xyz_cd_m2.y(), mean.device_xyz_cd_m2->y()),
                      "measure again; an instrument with narrower bands may be needed");
  range_.first_nm = mean.spectrum.first_nm;
  range_.step_nm = mean.spectrum.step_nm;
  range_.last_nm =
      range_.first_nm + range_.step_nm * static_cast<double>(mean.spectrum.values.size() - 1);
  return mean;
}

SpectralReading Spotread::measure_once(const Deadline& deadline) {
  const ScratchFolder folder;
  const fs::path file = folder.path() / "reading.sp";
  const ChildResult result = run_child(
      "spotread",
      {settings_.program, "-c", std::to_string(settings_.port), "-e", "-x", "-O", file.string()},
      deadline);
  const std::optional<Eigen::Vector3d> xyz = parse_spotread_xyz(result.output);
  if (result.exit_status != 0)
    throw DeviceError(Kind::kRefused,
                      fmt::format("spotread ends with status {}: {}", result.exit_status,
                                  last_line(result.output)),
                      "run it by hand to see what it wants");
  if (!xyz)
    throw DeviceError(Kind::kProtocol, "spotread gives no XYZ but: " + last_line(result.output),
                      "run it by hand to see what it wants");
  SpectralReading reading;
  if (!fs::exists(file))
    throw DeviceError(Kind::kRefused, "spotread writes no spectrum",
                      "use an instrument that measures spectra, and ArgyllCMS 2 or later");
  reading.spectrum = parse_cgats_spectrum("spotread", read_text(file, kLargestSpectrum));
  if (reading.spectrum.step_nm > 20)
    throw DeviceError(Kind::kProtocol, "spotread writes a spectrum in steps beyond 20 nm",
                      "use another instrument");
  reading.device_xyz_cd_m2 = *xyz;
  return reading;
}

}  // namespace wheatstone
