#include "core/csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/error.h"
#include "core/files.h"

namespace wheatstone {
namespace {

std::string joined(const std::vector<std::string>& names) {
  std::string out;
  for (const std::string& n : names) out += (out.empty() ? "" : ", ") + n;
  return out;
}

/// What is wrong with these column names, or "".
std::string header_problem(const std::vector<std::string>& columns) {
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i].empty()) return "column " + std::to_string(i + 1) + " has no name";
    if (std::count(columns.begin(), columns.end(), columns[i]) > 1)
      return "column '" + columns[i] + "' is named twice";
  }
  return columns.empty() ? "there is no column" : "";
}

/// Splits text into records of cells; a record begins on line `line` (1-based).
struct Record {
  std::size_t line;
  std::vector<std::string> cells;
};
std::vector<Record> parse(const std::string& text, const std::filesystem::path& path) {
  std::vector<Record> records;
  std::size_t line = 1, at = text.starts_with("\xEF\xBB\xBF") ? 3 : 0;  // byte-order mark
  while (at < text.size()) {
    Record record{line, {""}};
    for (bool quoted = false; at < text.size(); ++at) {
      const char c = text[at];
      if (c == '\n') ++line;
      if (quoted) {
        if (c != '"')
          record.cells.back() += c;
        else if (at + 1 < text.size() && text[at + 1] == '"')
          record.cells.back() += text[++at];
        else
          quoted = false;
        if (at + 1 == text.size() && quoted)
          throw FileError(path, "line " + std::to_string(record.line) + ": a quote is never closed",
                          "close it with \"");
      } else if (c == '"' && record.cells.back().empty()) {
        quoted = true;
      } else if (c == ',') {
        record.cells.emplace_back();
      } else if (c == '\n') {
        ++at;
        break;
      } else if (c != '\r') {
        record.cells.back() += c;
      }
    }
    if (record.cells.size() > 1 || !record.cells[0].empty()) records.push_back(std::move(record));
  }
  return records;
}

std::string quoted_if_needed(const std::string& cell) {
  if (cell.find_first_of(",\"\r\n") == std::string::npos) return cell;
  std::string out = "\"";
  for (const char c : cell) out += c == '"' ? "\"\"" : std::string(1, c);
  return out + "\"";
}

std::string shortest(double v) {
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, v).ptr;
  return std::isnan(v) ? "nan" : std::string(buffer, end);
}

}  // namespace

CsvTable::CsvTable(std::vector<std::string> columns) : columns_(std::move(columns)) {
  if (const std::string problem = header_problem(columns_); !problem.empty())
    throw ArgumentError("table: " + problem, "name every column once");
}

CsvTable CsvTable::read(const std::filesystem::path& path) {
  std::vector<Record> records = parse(read_text(path), path);
  if (records.empty()) throw FileError(path, "is empty", "give a table with a header line");
  CsvTable table;
  table.file_ = path.string();
  table.columns_ = std::move(records[0].cells);
  if (const std::string problem = header_problem(table.columns_); !problem.empty())
    throw FileError(path, "line " + std::to_string(records[0].line) + ": " + problem,
                    "name every column once in the header line");
  for (std::size_t i = 1; i < records.size(); ++i) {
    if (records[i].cells.size() != table.columns_.size())
      throw FileError(path,
                      "line " + std::to_string(records[i].line) + " has " +
                          std::to_string(records[i].cells.size()) + " cells, the header " +
                          std::to_string(table.columns_.size()),
                      "give every row a cell for each column");
    table.lines_.push_back(records[i].line);
    table.cells_.push_back(std::move(records[i].cells));
  }
  return table;
}

void CsvTable::write(const std::filesystem::path& path) const {
  std::string text;
  const auto add = [&](const std::vector<std::string>& cells) {
    for (std::size_t i = 0; i < cells.size(); ++i)
      text += (i ? "," : "") + quoted_if_needed(cells[i]);
    text += '\n';
  };
  add(columns_);
  for (const auto& row : cells_) add(row);
  write_text_atomically(path, text);
}

bool CsvTable::has(const std::string& column) const {
  return std::find(columns_.begin(), columns_.end(), column) != columns_.end();
}

std::size_t CsvTable::index(const std::string& column) const {
  const auto at = std::find(columns_.begin(), columns_.end(), column);
  if (at == columns_.end())
    throw FileError(file_, "has no column '" + column + "'",
                    "add it; the columns are: " + joined(columns_));
  return static_cast<std::size_t>(at - columns_.begin());
}

std::string CsvTable::where(std::size_t row) const {
  const std::size_t line = lines_.at(row);
  return file_ + (line ? ":" + std::to_string(line) : ", row " + std::to_string(row + 1));
}

const std::string& CsvTable::text(std::size_t row, const std::string& column) const {
  return cells_.at(row)[index(column)];
}

double CsvTable::number(std::size_t row, const std::string& column) const {
  const std::string& cell = text(row, column);
  const auto first = cell.find_first_not_of(" \t"), last = cell.find_last_not_of(" \t");
  double value = 0;
  if (first != std::string::npos) {
    const char* begin = cell.data() + first + (cell[first] == '+' ? 1 : 0);
    const char* end = cell.data() + last + 1;
    const auto [parsed_to, error] = std::from_chars(begin, end, value);
    if (error == std::errc() && parsed_to == end) return value;
  }
  throw FileError(where(row), "column '" + column + "' holds '" + cell + "'", "give a number");
}

double CsvTable::finite_number(std::size_t row, const std::string& column) const {
  const double value = number(row, column);
  if (!std::isfinite(value))
    throw FileError(where(row), "column '" + column + "' holds '" + text(row, column) + "'",
                    "give a finite number");
  return value;
}

std::vector<double> CsvTable::numbers(const std::string& column) const {
  std::vector<double> out;
  for (std::size_t row = 0; row < rows(); ++row) out.push_back(number(row, column));
  return out;
}

void CsvTable::add_row(std::vector<std::string> cells) {
  if (cells.size() != columns_.size())
    throw ArgumentError("a row of " + std::to_string(cells.size()) + " cells in a table of " +
                            std::to_string(columns_.size()) + " columns",
                        "give a cell for each column");
  cells_.push_back(std::move(cells));
  lines_.push_back(0);
}

void CsvTable::set_column(const std::string& name, const std::vector<double>& values) {
  std::vector<std::string> texts;
  for (const double v : values) texts.push_back(shortest(v));
  set_column(name, std::move(texts));
}

void CsvTable::set_column(const std::string& name, std::vector<std::string> values) {
  if (values.size() != rows())
    throw ArgumentError("column '" + name + "' has " + std::to_string(values.size()) +
                            " values, the table " + std::to_string(rows()) + " rows",
                        "give one value for each row");
  if (!has(name)) {
    columns_.push_back(name);
    for (auto& row : cells_) row.emplace_back();
  }
  const std::size_t column = index(name);
  for (std::size_t row = 0; row < rows(); ++row) cells_[row][column] = std::move(values[row]);
}

}  // namespace wheatstone
