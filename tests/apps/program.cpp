#include "program.h"

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <random>

#include "apps/stations.h"
#include "capture/alignment.h"
#include "sim/simulated_rig.h"

namespace wheatstone::apps {

namespace fs = std::filesystem;

namespace {

std::string read_to_end(int fd) {
  std::string text;
  std::array<char, 4096> buffer;
  for (ssize_t n = 0; (n = ::read(fd, buffer.data(), buffer.size())) > 0;)
    text.append(buffer.data(), static_cast<std::size_t>(n));
  ::close(fd);
  return text;
}

fs::path new_temporary_folder() {
  std::string pattern = (fs::temp_directory_path() / "wheatstone_apps_XXXXXX").string();
  if (::mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no temporary folder");
  return pattern;
}

}  // namespace

void become_program(std::vector<std::string> arguments, const Surroundings& around) {
  for (const std::string& variable : around.environment) {
    const auto equals = variable.find('=');
    ::setenv(variable.substr(0, equals).c_str(), variable.c_str() + equals + 1, 1);
  }
  if (around.largest_file_bytes) {
    // Ignored, the signal becomes an error of write(), as with a full disk.
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{*around.largest_file_bytes, *around.largest_file_bytes};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  arguments.insert(arguments.begin(), WHEATSTONE_PROGRAM);
  std::vector<char*> argv;
  for (std::string& a : arguments) argv.push_back(a.data());
  argv.push_back(nullptr);
  ::execv(WHEATSTONE_PROGRAM, argv.data());
  ::_exit(127);
}

Outcome run_program(const std::vector<std::string>& arguments, const Surroundings& around) {
  std::array<int, 2> in{}, out{}, err{};
  if (::pipe(in.data()) != 0 || ::pipe(out.data()) != 0 || ::pipe(err.data()) != 0)
    throw std::runtime_error("no pipe");
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(in[0], STDIN_FILENO);
    ::dup2(out[1], STDOUT_FILENO);
    ::dup2(err[1], STDERR_FILENO);
    for (int fd : {in[0], in[1], out[0], out[1], err[0], err[1]}) ::close(fd);
    become_program(arguments, around);
  }
  if (::write(in[1], around.input.data(), around.input.size()) < 0)
    throw std::runtime_error("the program takes no input");
  for (int fd : {in[0], in[1], out[1], err[1]}) ::close(fd);
  if (child < 0) throw std::runtime_error("no child process");
  int status = 0;
  bool ended = false;
  if (around.kill_when) {
    while (!ended && !around.kill_when()) ended = ::waitpid(child, &status, WNOHANG) == child;
    if (!ended) ::kill(child, SIGKILL);
  }
  // One after the other is safe: messages are far shorter than a pipe.
  Outcome outcome;
  outcome.out = read_to_end(out[0]);
  outcome.err = read_to_end(err[0]);
  if (!ended) ::waitpid(child, &status, 0);
  outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return outcome;
}

void expect_refused(const Outcome& outcome, const std::vector<std::string>& parts) {
  EXPECT_EQ(outcome.status, 1) << outcome.err;
  EXPECT_THAT(outcome.err, ::testing::HasSubstr("wheatstone: "));
  EXPECT_THAT(outcome.err, ::testing::Not(::testing::HasSubstr("internal error")));
  for (const std::string& part : parts) EXPECT_THAT(outcome.err, ::testing::HasSubstr(part));
}

void expect_nothing_half_written(const fs::path& folder) {
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    EXPECT_EQ(entry.path().filename().string().find(".part"), std::string::npos) << entry.path();
}

TemporaryFolder::TemporaryFolder() : root_(new_temporary_folder()) {}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(root_, ignored);
}

Dataset write_small_light_field(const fs::path& root) {
  const Dataset dataset(root);
  fs::create_directories(root);
  SimulatedRig twin({"card", 0.05, 7});
  record_alignments(twin.rig(), dataset);
  calibrate_eyes(dataset);

  std::mt19937 random(1);
  std::uniform_real_distribution<float> light_cd_m2(1, 100);
  std::vector<LightFieldView> views;
  for (int i = 0; i < 3; ++i) {
    LightFieldView view{"view_" + std::to_string(i), RgbImage(48, 36), {}, {}};
    for (cv::Vec3f& pixel : view.light_cd_m2.pixels)
      for (int c = 0; c < 3; ++c) pixel[c] = light_cd_m2(random);
    view.intrinsics = {60, 60, 0, 23.5, 17.5, 48, 36};
    const Eigen::Vector3d centre_mm(145 + 40 * i, 130, 550);
    view.T_camera_world.R = straight_R_camera_rsb();
    view.T_camera_world.t_mm = -(view.T_camera_world.R * centre_mm);
    views.push_back(view);
  }
  store_light_field(dataset, views);
  dataset.write_manifest({"capture", "card", 7, 0.05, "test", 0, 1});
  return dataset;
}

}  // namespace wheatstone::apps
