#include "capture/noise_profile.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "core/files.h"
#include "core/random.h"
#include "tests/shared_data.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

const std::filesystem::path kProfiles = WHEATSTONE_SOURCE_DIR "/profiles";

TEST(NoiseProfile, TheFourOfTheReference) {
  const struct {
    const char* file;
    SensorNoise noise;
    int bits;
  } expected[] = {{"sony_a7r.toml", {{0.327064, 0.330341, 0.32096}, 0.699102, 0.0358603}, 14},
                  {"sony_a7r3.toml", {{0.422044, 0.384277, 0.388967}, 0.705127, 3.02845}, 14},
                  {"canon_t1.toml", {{1.36308, 1.18256, 1.15319}, 0.938028, 5.00525}, 14},
                  {"samsung_s9.toml", {{0.303362, 0.312534, 0.320971}, 1.06331, 2.3726}, 10}};
  for (const auto& e : expected) {
    const NoiseProfile p = read_noise_profile(kProfiles / e.file);
    EXPECT_EQ(p.noise.dn_per_electron, e.noise.dn_per_electron) << e.file;
    EXPECT_EQ(p.noise.read_noise_e, e.noise.read_noise_e) << e.file;
    EXPECT_EQ(p.noise.adc_noise, e.noise.adc_noise) << e.file;
    EXPECT_EQ(p.bits, e.bits) << e.file;
  }
}

TEST(NoiseProfile, ReadsBackExactly) {
  const TemporaryFolder folder;
  const NoiseProfile p{"a \"quoted\" camera", 12, {{1.0 / 3, 0.1, 7e-3}, 0, 2.0 / 7}, "test"};
  write_noise_profile(folder.path / "p.toml", p);
  const NoiseProfile q = read_noise_profile(folder.path / "p.toml");
  EXPECT_EQ(q.camera, p.camera);
  EXPECT_EQ(q.bits, 12);
  EXPECT_EQ(q.noise.dn_per_electron, p.noise.dn_per_electron);
  EXPECT_EQ(q.noise.read_noise_e, 0);
  EXPECT_EQ(q.noise.adc_noise, p.noise.adc_noise);
}

TEST(NoiseProfile, BadFilesAreRefusedByKey) {
  const TemporaryFolder folder;
  const auto file = folder.path / "p.toml";
  const std::string good = read_text(kProfiles / "canon_t1.toml");
  const auto refused = [&](const std::string& text, const std::string& part) {
    write_text_atomically(file, text);
    try {
      read_noise_profile(file);
      FAIL() << part;
    } catch (const FileError& e) {
      EXPECT_THAT(e.what(), testing::HasSubstr(file.string()));
      EXPECT_THAT(e.what(), testing::HasSubstr(part));
    }
  };
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    return text.replace(text.find(from), from.size(), to);
  };
  refused("", "schema");
  refused("std_read = ", "line 1");
  refused(replaced("noise/1", "noise/2"), "schema");
  refused(replaced("std_read = 0.938028", ""), "std_read");
  refused(replaced("0.938028", "-1"), "std_read");
  refused(replaced("0.938028", "nan"), "std_read");
  refused(replaced("1.36308, ", ""), "noise_k_rgb");
  refused(replaced("1.36308", "0"), "noise_k_rgb");
  refused(replaced("1.36308", "\"high\""), "noise_k_rgb");
  refused(replaced("bits = 14", "bits = 40"), "bits");
  refused(good + "\ngain = 2\n", "gain");
  EXPECT_THROW(read_noise_profile(folder.path / "none.toml"), FileError);
}

TEST(NoiseProfile, DamagedFilesAreReadOrRefused) {
  const TemporaryFolder folder;
  const std::string good = read_text(kProfiles / "canon_t1.toml");
  int read = 0, refused = 0;
  for (std::uint64_t i = 0; i < 500; ++i) {
    RandomStream random(6, i);
    std::string text = good;
    for (std::uint64_t k = 0, flips = 1 + random.next() % 3; k < flips; ++k)
      text[random.next() % text.size()] ^= static_cast<char>(1U << (random.next() % 8));
    if (random.next() % 8 == 0) text.resize(random.next() % text.size());
    write_text_atomically(folder.path / "p.toml", text);
    try {
      read_noise_profile(folder.path / "p.toml");
      ++read;
    } catch (const FileError&) {
      ++refused;
    }
  }
  EXPECT_GT(read, 20);
  EXPECT_GT(refused, 20);
}

}  // namespace
}  // namespace wheatstone
