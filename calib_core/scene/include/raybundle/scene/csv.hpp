// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace raybundle {

/// A line of a comma-separated table. Fields are trimmed of blanks and may stand in double quotes.
struct CsvRow {
  int line = 0;  ///< in the file, from 1
  std::vector<std::string> fields;
};

/// A comma-separated table without its blank lines and lines that start with #.
struct CsvTable {
  std::string file;  ///< for messages
  std::vector<CsvRow> rows;
};

/// What the columns of a table are called; optional ones stand last when the table has no header.
struct CsvColumns {
  std::vector<std::string_view> required;
  std::vector<std::string_view> optional;
};

/// Splits a text into rows.
///
/// @param file  name for messages
/// @throws Error(kBadInput) `file:line: ...` for an open quote, text behind a closing one, or a row of more than 64
/// fields
CsvTable csv_from_text(std::string_view text, const std::string& file);

/// The same for a file.
///
/// @throws Error(kIo) when it cannot be read
CsvTable read_csv(const std::filesystem::path& path);

/// Takes the header off, when there is one, and puts the fields of every row into the order required, optional;
/// optional fields that a row lacks are empty. The first row is a header when it holds one of the names.
///
/// @throws Error(kBadInput) for a missing or unknown column name and for rows with too few or too many fields
void arrange_columns(CsvTable& table, const CsvColumns& columns);

/// A field as a finite number.
///
/// @param name  of the column, for messages
/// @throws Error(kBadInput) `file:line: u is 'abc', which is not a number; ...`
double number_in(const CsvTable& table, const CsvRow& row, std::size_t column, std::string_view name);

/// A field as a whole number that fits an int.
int whole_number_in(const CsvTable& table, const CsvRow& row, std::size_t column, std::string_view name);

/// Throws Error(kBadInput) with the message at a row of the table.
[[noreturn]] void fail_at(const CsvTable& table, const CsvRow& row, const std::string& message);

/// The whole text of a file.
///
/// @throws Error(kIo) when it cannot be read, is a folder or is larger than 1 GB
std::string text_of_file(const std::filesystem::path& path);

/// Foreign text for a message: in single quotes, without control characters, at most about 60 bytes.
std::string in_quotes(std::string_view text);

}  // namespace raybundle
