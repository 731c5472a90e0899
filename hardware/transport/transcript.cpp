#include "hardware/transport/transcript.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/files.h"

namespace wheatstone {
namespace {

std::string hex(std::string_view bytes) {
  std::string out;
  for (const char c : bytes) out += fmt::format("{:02x}", static_cast<unsigned char>(c));
  return out;
}

std::string bytes_of(const std::string& hex_text) {
  if (hex_text.size() % 2) throw std::invalid_argument("an odd number of digits");
  std::string out;
  for (std::size_t i = 0; i < hex_text.size(); i += 2) {
    if (!std::isxdigit(static_cast<unsigned char>(hex_text[i])) ||
        !std::isxdigit(static_cast<unsigned char>(hex_text[i + 1])))
      throw std::invalid_argument("no hexadecimal digits");
    out += static_cast<char>(std::stoi(hex_text.substr(i, 2), nullptr, 16));
  }
  return out;
}

}  // namespace

Transcript::Transcript(const std::filesystem::path& file)
    : handle_(::open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644)) {
  if (handle_ < 0)
    throw FileError(file, std::string("cannot be written (") + std::strerror(errno) + ")",
                    "choose a folder that exists and is writable");
}

Transcript::~Transcript() {
  if (handle_ >= 0) ::close(handle_);
}

void Transcript::add(const char* to, std::string_view bytes) {
  if (handle_ < 0) return;
  const std::string line = fmt::format(R"({{"ns": {}, "to": "{}", "hex": "{}"}})"
                                       "\n",
                                       SteadyClock().now_ns(), to, hex(bytes));
  const std::lock_guard lock(mutex_);
  if (::write(handle_, line.data(), line.size()) != static_cast<ssize_t>(line.size())) {
    ::close(handle_);
    handle_ = -1;
  }
}

std::vector<TranscriptEntry> read_transcript(const std::filesystem::path& file) {
  const std::string text = read_text(file);
  std::vector<TranscriptEntry> out;
  std::size_t number = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    ++number;
    try {
      const auto line = nlohmann::json::parse(text.substr(at, end - at));
      const std::string to = line.at("to").get<std::string>();
      if (to != "device" && to != "host") throw std::invalid_argument("neither device nor host");
      out.push_back({line.at("ns").get<Nanoseconds>(), to == "device",
                     bytes_of(line.at("hex").get<std::string>())});
    } catch (const std::exception& e) {
      throw FileError(file, fmt::format("line {} is no transcript entry: {}", number, e.what()),
                      "use a file that was recorded");
    }
    at = end + 1;
  }
  return out;
}

std::string hex_of(std::string_view bytes, std::size_t longest) {
  std::string out;
  for (std::size_t i = 0; i < std::min(bytes.size(), longest); ++i)
    out += fmt::format("{}{:02x}", i ? " " : "", static_cast<unsigned char>(bytes[i]));
  return bytes.size() > longest ? out + " ..." : out;
}

std::string printable(std::string_view text) {
  std::string out(text);
  std::replace_if(
      out.begin(), out.end(), [](unsigned char c) { return c < 0x20 || c > 0x7e; }, '?');
  return out;
}

}  // namespace wheatstone
