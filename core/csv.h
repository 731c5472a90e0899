#pragma once
// Tables as CSV: one header line of column names (units in the names), commas, no quoting needed
// for numbers. Reading is strict, so that a slipped column never becomes a number of another kind.

#include <filesystem>
#include <string>
#include <vector>

namespace wheatstone {

/// Cells are kept as text, so that a table can be passed on without rounding.
class CsvTable {
 public:
  CsvTable() = default;
  /// Errors: ArgumentError for no column, an empty name or a name given twice.
  explicit CsvTable(std::vector<std::string> columns);

  /// Errors: FileError naming file and line: missing, empty, bad header, a row with another number
  /// of cells than the header (ragged), an unfinished quote. Blank lines and CRLF are accepted.
  static CsvTable read(const std::filesystem::path&);
  /// Atomic. Cells that hold a comma, quote or line break are quoted (RFC 4180).
  void write(const std::filesystem::path&) const;

  const std::vector<std::string>& columns() const { return columns_; }
  std::size_t rows() const { return cells_.size(); }
  bool has(const std::string& column) const;

  /// Errors: FileError naming the file, the missing column and those that exist.
  const std::string& text(std::size_t row, const std::string& column) const;
  /// Errors: the same, and for a cell that is not wholly a number: file, line, column, content.
  /// Accepts "nan", "inf" (any case): whoever needs finite numbers uses finite_number().
  double number(std::size_t row, const std::string& column) const;
  double finite_number(std::size_t row, const std::string& column) const;
  std::vector<double> numbers(const std::string& column) const;  // number() of every row

  /// Appends a row; ArgumentError unless it has as many cells as there are columns.
  void add_row(std::vector<std::string> cells);
  /// Appends or replaces a column; values print so that they read back exactly (NaN as "nan").
  void set_column(const std::string& name, const std::vector<double>& values);
  void set_column(const std::string& name, std::vector<std::string> values);

  /// "file:line" of a row, for errors about what its cells mean.
  std::string where(std::size_t row) const;

 private:
  std::size_t index(const std::string& column) const;

  std::string file_ = "table";
  std::vector<std::string> columns_;
  std::vector<std::vector<std::string>> cells_;
  std::vector<std::size_t> lines_;  // 1-based line of each row in the file; 0 when made in memory
};

}  // namespace wheatstone
