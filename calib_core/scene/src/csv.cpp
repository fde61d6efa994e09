// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/scene/csv.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <system_error>
#include <utility>

#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/number.hpp"

namespace raybundle {
namespace {

constexpr std::size_t kMaxFields = 64;  // bounds the memory that a file of commas can ask for
constexpr std::uintmax_t kMaxFileBytes = 1'000'000'000;

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

// Takes one field and its comma off the front of what is left of a row.
std::string take_field(std::string_view& rest, const CsvTable& table, const CsvRow& row) {
  rest.remove_prefix(std::min(rest.find_first_not_of(" \t"), rest.size()));
  if (!rest.starts_with('"')) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    std::string field(trimmed(rest.substr(0, comma)));
    rest.remove_prefix(std::min(comma + 1, rest.size()));
    return field;
  }
  std::string field;
  for (std::size_t i = 1; i < rest.size(); ++i) {
    if (rest[i] != '"') {
      field += rest[i];
    } else if (i + 1 < rest.size() && rest[i + 1] == '"') {
      field += rest[i++];
    } else {
      const std::size_t comma = std::min(rest.find(',', i), rest.size());
      if (!trimmed(rest.substr(i + 1, comma - i - 1)).empty()) {
        fail_at(table, row, "there is text behind a closing double quote; put it inside, or leave the quotes out");
      }
      rest.remove_prefix(std::min(comma + 1, rest.size()));
      return field;
    }
  }
  fail_at(table, row, "a double quote is opened but not closed; close it or leave it out");
}

std::string listed(const std::vector<std::string_view>& names) {
  std::string text;
  for (const std::string_view name : names) text += (text.empty() ? "" : ",") + std::string(name);
  return text;
}

std::vector<std::string_view> all_names(const CsvColumns& columns) {
  std::vector<std::string_view> names = columns.required;
  names.insert(names.end(), columns.optional.begin(), columns.optional.end());
  return names;
}

// Place of each named column in the file, from the header row; nothing when the row is not a header.
std::optional<std::vector<std::size_t>> places_from_header(const CsvTable& table, const CsvColumns& columns) {
  const CsvRow& row = table.rows.front();
  const std::vector<std::string_view> names = all_names(columns);
  const auto known = [&](const std::string& field) { return std::ranges::find(names, field) != names.end(); };
  const auto is_number = [](const std::string& field) { return number_from<double>(field).has_value(); };
  if (std::ranges::none_of(row.fields, known)) return std::nullopt;
  if (std::ranges::any_of(row.fields, is_number)) return std::nullopt;  // of a camera that is called camera, say

  const std::string expected = "the columns are " + listed(names);
  std::vector<std::size_t> places;
  for (const std::string_view name : names) {
    const auto found = std::ranges::find(row.fields, name);
    if (found == row.fields.end() && places.size() < columns.required.size()) {
      fail_at(table, row, "the header has no column " + std::string(name) + "; " + expected);
    }
    places.push_back(static_cast<std::size_t>(found - row.fields.begin()));
  }
  for (const std::string& field : row.fields) {
    if (!known(field)) fail_at(table, row, "unknown column " + in_quotes(field) + " in the header; " + expected);
    if (std::ranges::count(row.fields, field) > 1) {
      fail_at(table, row, "column " + field + " stands twice in the header; leave one out");
    }
  }
  return places;
}

}  // namespace

CsvTable csv_from_text(std::string_view text, const std::string& file) {
  CsvTable table{file, {}};
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);  // the byte order mark that spreadsheets write
  for (int line = 1; !text.empty(); ++line) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view rest = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (rest.empty() || rest.starts_with('#')) continue;

    CsvRow row{line, {}};
    bool ends_in_comma = false;
    do {
      ends_in_comma = rest.ends_with(',');
      row.fields.push_back(take_field(rest, table, row));
      if (row.fields.size() > kMaxFields) {
        fail_at(table, row, "more than 64 fields in one line; is this a comma-separated table?");
      }
    } while (!rest.empty());
    if (ends_in_comma) row.fields.emplace_back();
    table.rows.push_back(std::move(row));
  }
  return table;
}

CsvTable read_csv(const std::filesystem::path& path) { return csv_from_text(text_of_file(path), path.string()); }

void arrange_columns(CsvTable& table, const CsvColumns& columns) {
  if (table.rows.empty()) return;
  const std::size_t required = columns.required.size();
  const std::size_t total = required + columns.optional.size();
  const auto header = places_from_header(table, columns);
  if (header) table.rows.erase(table.rows.begin());

  for (CsvRow& row : table.rows) {
    std::size_t needed = required;
    if (header) {
      for (std::size_t i = 0; i < required; ++i) needed = std::max(needed, (*header)[i] + 1);
    }
    if (row.fields.size() < needed || row.fields.size() > total) {
      std::string expected = std::to_string(required);
      if (total > required) expected += " to " + std::to_string(total);
      fail_at(table, row,
              std::to_string(row.fields.size()) + " fields where " + expected + " are expected; the columns are " +
                  listed(all_names(columns)));
    }
    std::vector<std::string> arranged(total);
    for (std::size_t i = 0; i < total; ++i) {
      const std::size_t place = header ? (*header)[i] : i;
      if (place < row.fields.size()) arranged[i] = std::move(row.fields[place]);
    }
    row.fields = std::move(arranged);
  }
}

double number_in(const CsvTable& table, const CsvRow& row, std::size_t column, std::string_view name) {
  const std::string& field = row.fields.at(column);
  const std::optional<double> value = number_from<double>(field);
  if (!value || !std::isfinite(*value)) {
    fail_at(table, row,
            std::string(name) + " is " + in_quotes(field) + ", which is not a finite number; correct the field");
  }
  return *value;
}

int whole_number_in(const CsvTable& table, const CsvRow& row, std::size_t column, std::string_view name) {
  const std::string& field = row.fields.at(column);
  const std::optional<int> value = number_from<int>(field);
  if (!value) {
    fail_at(table, row,
            std::string(name) + " is " + in_quotes(field) + ", which is not a whole number; correct the field");
  }
  return *value;
}

void fail_at(const CsvTable& table, const CsvRow& row, const std::string& message) {
  throw Error(ErrorKind::kBadInput, message, table.file + ":" + std::to_string(row.line));
}

std::string text_of_file(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) {
    throw Error(ErrorKind::kIo, "there is no such file; check the path", path.string());
  }
  if (std::filesystem::is_directory(status)) {
    throw Error(ErrorKind::kIo, "this is a folder; name a file in it", path.string());
  }
  if (std::filesystem::is_regular_file(status) && std::filesystem::file_size(path, error) > kMaxFileBytes) {
    throw Error(ErrorKind::kIo, "the file is larger than 1 GB; is it the right one?", path.string());
  }
  std::ifstream stream(path, std::ios::binary);
  std::string text;
  char buffer[65536];
  while (stream.read(buffer, sizeof buffer) || stream.gcount() > 0) {
    text.append(buffer, static_cast<std::size_t>(stream.gcount()));
    if (text.size() > kMaxFileBytes)
      throw Error(ErrorKind::kIo, "more than 1 GB; is it the right file?", path.string());
  }
  if (!stream.eof()) {
    throw Error(ErrorKind::kIo, "the file cannot be read; check its permissions", path.string());
  }
  return text;
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t kLimit = 60;
  std::string shown = "'";
  for (const char c : text.substr(0, kLimit)) {
    shown += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
  }
  return shown + (text.size() > kLimit ? "...'" : "'");
}

}  // namespace raybundle
