#pragma once
// Places for the files of a test. ctest runs many tests at once, so no name is fixed.

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>

/// A fresh folder, removed at the end.
struct TemporaryFolder {
  std::filesystem::path path;
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "wheatstone.XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::runtime_error("no temporary folder");
    path = name;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
};

/// `name` in a folder of this test program's own.
inline std::filesystem::path temporary_file(const std::string& name) {
  static const TemporaryFolder folder;
  return folder.path / name;
}
