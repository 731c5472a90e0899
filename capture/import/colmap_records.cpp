#include "capture/import/colmap_records.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <limits>
#include <string_view>

#include "core/error.h"

namespace wheatstone::colmap_detail {

void Place::fail(const std::string& what) const {
  throw FileError(*file, std::string(unit) + " " + std::to_string(number) + " has " + what,
                  "export the model from COLMAP again");
}

namespace {

constexpr std::uint64_t kNoPoint = std::numeric_limits<std::uint64_t>::max();

struct Model {
  const char* name;
  std::size_t parameters;
};
constexpr std::array<Model, 7> kModels = {  // in the order of COLMAP's binary model numbers
    Model{"SIMPLE_PINHOLE", 3},
    {"PINHOLE", 4},
    {"SIMPLE_RADIAL", 4},
    {"RADIAL", 5},
    {"OPENCV", 8},
    {"OPENCV_FISHEYE", 8},
    {"FULL_OPENCV", 12}};
constexpr const char* kModelNames =
    " (SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, OPENCV_FISHEYE and FULL_OPENCV are "
    "read)";

// ---- text ----

class Words {
 public:
  Words(std::string_view line, Place place) : rest_(line), place_(std::move(place)) {}

  bool at_end() {
    const auto start = rest_.find_first_not_of(" \t\r");
    rest_.remove_prefix(start == std::string_view::npos ? rest_.size() : start);
    return rest_.empty();
  }
  std::string_view word(const char* what) {
    if (at_end()) place_.fail(std::string("no ") + what);
    const auto w = rest_.substr(0, rest_.find_first_of(" \t\r"));
    rest_.remove_prefix(w.size());
    return w;
  }
  template <class T>
  T number(const char* what) {
    const auto w = word(what);
    T value{};
    const auto [end, error] = std::from_chars(w.data(), w.data() + w.size(), value);
    if (error != std::errc() || end != w.data() + w.size())
      place_.fail(std::string("a bad ") + what);
    return value;
  }
  /// What is left of the line: a picture name may hold spaces.
  std::string rest(const char* what) {
    if (at_end()) place_.fail(std::string("no ") + what);
    return std::string(rest_.substr(0, rest_.find_last_not_of(" \t\r") + 1));
  }
  const Place& place() const { return place_; }

 private:
  std::string_view rest_;
  Place place_;
};

class Lines {
 public:
  Lines(std::string_view text, const std::filesystem::path& file)
      : text_(text), place_{std::make_shared<const std::filesystem::path>(file), "line", 0} {}

  bool at_end() const { return text_.empty(); }
  Words next() {
    const auto length = std::min(text_.find('\n'), text_.size());
    const Words words(text_.substr(0, length), (++place_.number, place_));
    text_.remove_prefix(std::min(length + 1, text_.size()));
    return words;
  }
  /// Calls f for each line that is neither empty nor a comment.
  template <class F>
  void for_each_record(F f) {
    while (!at_end()) {
      const bool comment = text_.front() == '#';
      Words words = next();
      if (!comment && !words.at_end()) f(words);
    }
  }

 private:
  std::string_view text_;
  Place place_;
};

Camera text_camera(Words& w) {
  Camera c;
  c.place = w.place();
  c.id = w.number<std::uint32_t>("camera number");
  c.model = w.word("camera model");
  c.width = w.number<std::uint64_t>("width");
  c.height = w.number<std::uint64_t>("height");
  for (const Model& m : kModels)
    if (c.model == m.name)
      while (c.parameters.size() < m.parameters)
        c.parameters.push_back(w.number<double>("camera parameter"));
  if (c.parameters.empty()) c.place.fail("the unread camera model " + c.model + kModelNames);
  if (!w.at_end()) c.place.fail("too many camera parameters");
  return c;
}

Image text_image(Words& w) {
  Image i;
  i.place = w.place();
  i.id = w.number<std::uint32_t>("image number");
  for (double& q : i.q_wxyz) q = w.number<double>("quaternion");
  for (double& t : i.t) t = w.number<double>("translation");
  i.camera = w.number<std::uint32_t>("camera number");
  i.name = w.rest("picture name");
  return i;
}

void text_observations(Words& w, Image& image) {
  while (!w.at_end()) {
    Observation o;
    o.x = w.number<double>("observation x");
    o.y = w.number<double>("observation y");
    const auto point = w.number<std::int64_t>("observation's point number");
    if (point < -1) w.place().fail("a negative point number");
    o.point = static_cast<std::uint64_t>(point);
    if (point >= 0) image.observations.push_back(o);
  }
}

Point text_point(Words& w) {
  Point p;
  p.place = w.place();
  p.id = w.number<std::uint64_t>("point number");
  for (double& v : p.xyz) v = w.number<double>("point coordinate");
  for (auto& v : p.rgb) v = w.number<std::uint8_t>("point colour");
  p.error = w.number<double>("point error");
  while (!w.at_end()) w.number<std::int64_t>("track entry");
  return p;
}

Records read_text_records(const ColmapSource& s) {
  Records r;
  Lines(s.cameras, s.folder / "cameras.txt").for_each_record([&](Words& w) {
    r.cameras.push_back(text_camera(w));
  });
  Lines images(s.images, s.folder / "images.txt");
  images.for_each_record([&](Words& w) {
    r.images.push_back(text_image(w));
    // The next line belongs to this image even when it is empty: no point was found.
    if (images.at_end()) return;
    Words observations = images.next();
    text_observations(observations, r.images.back());
  });
  Lines(s.points, s.folder / "points3D.txt").for_each_record([&](Words& w) {
    r.points.push_back(text_point(w));
  });
  return r;
}

// ---- binary, little-endian ----

class Bytes {
 public:
  Bytes(std::string_view data, const std::filesystem::path& file)
      : data_(data), file_(std::make_shared<const std::filesystem::path>(file)) {}

  Place place() const { return {file_, "byte", at_}; }
  template <class T>
  T get(const char* what) {
    if (data_.size() - at_ < sizeof(T))
      place().fail(std::string("the file's end instead of ") + what);
    T value;
    std::memcpy(&value, data_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }
  /// A count of records that take at least `bytes_each`: it cannot exceed what the file holds.
  std::uint64_t count(std::size_t bytes_each, const char* what) {
    const Place here = place();
    const auto n = get<std::uint64_t>(what);
    if (n > (data_.size() - at_) / bytes_each)
      here.fail(std::string(what) + " " + std::to_string(n) + ", more than the file can hold");
    return n;
  }
  std::string zero_terminated(const char* what) {
    const auto end = data_.find('\0', at_);
    if (end == std::string_view::npos) place().fail(std::string("an endless ") + what);
    std::string s(data_.substr(at_, end - at_));
    at_ = end + 1;
    return s;
  }
  void skip(std::size_t n) { at_ += n; }
  void require_end() const {
    if (at_ != data_.size()) place().fail("bytes after the last record");
  }

 private:
  std::string_view data_;
  std::shared_ptr<const std::filesystem::path> file_;
  std::size_t at_ = 0;
};

Camera binary_camera(Bytes& b) {
  Camera c;
  c.place = b.place();
  c.id = b.get<std::uint32_t>("a camera number");
  const auto model = b.get<std::uint32_t>("a camera model");
  if (model >= kModels.size())
    c.place.fail("the unread camera model number " + std::to_string(model) + kModelNames);
  c.model = kModels[model].name;
  c.width = b.get<std::uint64_t>("a width");
  c.height = b.get<std::uint64_t>("a height");
  for (std::size_t i = 0; i < kModels[model].parameters; ++i)
    c.parameters.push_back(b.get<double>("a camera parameter"));
  return c;
}

Image binary_image(Bytes& b) {
  Image i;
  i.place = b.place();
  i.id = b.get<std::uint32_t>("an image number");
  for (double& q : i.q_wxyz) q = b.get<double>("a quaternion");
  for (double& t : i.t) t = b.get<double>("a translation");
  i.camera = b.get<std::uint32_t>("a camera number");
  i.name = b.zero_terminated("picture name");
  const auto observations = b.count(24, "the observation count");
  for (std::uint64_t k = 0; k < observations; ++k) {
    Observation o;
    o.x = b.get<double>("an observation");
    o.y = b.get<double>("an observation");
    o.point = b.get<std::uint64_t>("an observation");
    if (o.point != kNoPoint) i.observations.push_back(o);
  }
  return i;
}

Point binary_point(Bytes& b) {
  Point p;
  p.place = b.place();
  p.id = b.get<std::uint64_t>("a point number");
  for (double& v : p.xyz) v = b.get<double>("a point");
  for (auto& v : p.rgb) v = b.get<std::uint8_t>("a point's colour");
  p.error = b.get<double>("a point's error");
  b.skip(8 * b.count(8, "the track length"));
  return p;
}

Records read_binary_records(const ColmapSource& s) {
  Records r;
  Bytes cameras(s.cameras, s.folder / "cameras.bin");
  for (auto n = cameras.count(48, "the camera count"); n > 0; --n)
    r.cameras.push_back(binary_camera(cameras));
  cameras.require_end();
  Bytes images(s.images, s.folder / "images.bin");
  for (auto n = images.count(73, "the image count"); n > 0; --n)
    r.images.push_back(binary_image(images));
  images.require_end();
  Bytes points(s.points, s.folder / "points3D.bin");
  for (auto n = points.count(51, "the point count"); n > 0; --n)
    r.points.push_back(binary_point(points));
  points.require_end();
  return r;
}

}  // namespace

Records read_records(const ColmapSource& source) {
  return source.binary ? read_binary_records(source) : read_text_records(source);
}

}  // namespace wheatstone::colmap_detail
