// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/io/survey_files.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <tuple>

#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/csv.hpp"
#include "raybundle/scene/number.hpp"
#include "raybundle/scene/suggestion.hpp"

namespace raybundle {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

bool has_column(const CsvTable& table, std::string_view name) {
  return !table.rows.empty() && std::ranges::find(table.rows.front().fields, name) != table.rows.front().fields.end();
}

double sigma_in(const CsvTable& table, const CsvRow& row, std::size_t column) {
  const double sigma = number_in(table, row, column, "sigma");
  if (sigma < 0) fail_at(table, row, "sigma is " + row.fields[column] + "; it must not be negative");
  return sigma;
}

Landmark geodetic_landmark(const CsvTable& table, const CsvRow& row, const Geodetic& origin, const HeightDatum& datum) {
  const Geodetic place{number_in(table, row, 1, "lat"), number_in(table, row, 2, "lon"),
                       number_in(table, row, 3, "height") + datum.geoid_m};
  if (std::abs(place.latitude_deg) > 90.0 || std::abs(place.longitude_deg) > 360.0) {
    fail_at(table, row, "latitudes lie within ±90 degrees and longitudes within ±360; are the columns swapped?");
  }
  return {row.fields[0], enu_from_geodetic(origin, place), false, sigma_in(table, row, 4)};
}

Landmark local_landmark(const CsvTable& table, const CsvRow& row) {
  const Eigen::Vector3d x(number_in(table, row, 1, "east"), number_in(table, row, 2, "north"),
                          number_in(table, row, 3, "up"));
  return {row.fields[0], x, false, sigma_in(table, row, 4)};
}

Landmark far_landmark(const CsvTable& table, const CsvRow& row) {
  const double elevation = number_in(table, row, 2, "elevation");
  if (std::abs(elevation) > 90.0) fail_at(table, row, "elevations lie within ±90 degrees");
  return {row.fields[0], enu_from_azimuth(kDegree * number_in(table, row, 1, "azimuth"), kDegree * elevation), true,
          kDegree * sigma_in(table, row, 3)};
}

}  // namespace

HeightDatum height_datum_from_word(const std::string& word) {
  if (word == "ellipsoidal") return {};
  const std::string prefix = "orthometric:";
  if (word.starts_with(prefix)) {
    const std::optional<double> geoid_m = number_from<double>(std::string_view(word).substr(prefix.size()));
    if (geoid_m && std::abs(*geoid_m) < 150.0) return {*geoid_m};
  }
  throw Error(ErrorKind::kBadInput,
              in_quotes(word) +
                  " does not say what heights are above: write ellipsoidal, or orthometric:N with the geoid's height N "
                  "above the ellipsoid there in metres, as in orthometric:47.3");
}

std::vector<Landmark> landmarks_from_csv_text(std::string_view text, const std::string& name,
                                              const std::optional<Geodetic>& origin,
                                              const std::optional<HeightDatum>& datum) {
  CsvTable table = csv_from_text(text, name);
  const bool geodetic = has_column(table, "lat"), local = has_column(table, "east"), far = has_column(table, "azimuth");
  if (geodetic + local + far != 1) {
    throw Error(ErrorKind::kBadInput,
                "the first line must name the columns: name,lat,lon,height,sigma or name,east,north,up,sigma or "
                "name,azimuth,elevation,sigma",
                name);
  }
  if (geodetic && !origin) {
    throw Error(ErrorKind::kBadInput, "latitudes need the origin of the local frame; give --origin LAT,LON,HEIGHT",
                name);
  }
  if (geodetic && !datum) {
    throw Error(ErrorKind::kBadInput,
                "heights may be above the ellipsoid or above the sea, up to 100 m apart, and the table does not say "
                "which; give --height ellipsoidal, or --height orthometric:N with the geoid's height there",
                name);
  }
  arrange_columns(table, {geodetic ? std::vector<std::string_view>{"name", "lat", "lon", "height", "sigma"}
                          : local  ? std::vector<std::string_view>{"name", "east", "north", "up", "sigma"}
                                   : std::vector<std::string_view>{"name", "azimuth", "elevation", "sigma"},
                          {}});
  if (table.rows.empty()) throw Error(ErrorKind::kBadInput, "there are no landmarks in the file", name);
  std::vector<Landmark> landmarks;
  std::set<std::string> names;
  for (const CsvRow& row : table.rows) {
    landmarks.push_back(geodetic ? geodetic_landmark(table, row, *origin, *datum)
                        : local  ? local_landmark(table, row)
                                 : far_landmark(table, row));
    if (!names.insert(row.fields[0]).second)
      fail_at(table, row, "landmark " + in_quotes(row.fields[0]) + " stands twice");
  }
  return landmarks;
}

std::vector<Sighting> sightings_from_csv_text(std::string_view text, const std::string& name,
                                              const std::vector<Landmark>& landmarks) {
  CsvTable table = csv_from_text(text, name);
  arrange_columns(table, {{"image", "u", "v", "name"}, {"camera"}});
  if (table.rows.empty()) throw Error(ErrorKind::kBadInput, "there are no sightings in the file", name);
  std::vector<std::string> names;
  for (const Landmark& landmark : landmarks) names.push_back(landmark.name);
  std::vector<Sighting> sightings;
  std::set<std::tuple<std::string, std::string, std::string>> seen;
  for (const CsvRow& row : table.rows) {
    if (std::ranges::find(names, row.fields[3]) == names.end()) {
      fail_at(table, row,
              "landmark " + in_quotes(row.fields[3]) + " is not among the surveyed ones." +
                  did_you_mean(row.fields[3], names));
    }
    if (!seen.emplace(row.fields[0], row.fields[3], row.fields[4]).second) {
      fail_at(table, row, in_quotes(row.fields[3]) + " is seen a second time in " + in_quotes(row.fields[0]));
    }
    const Eigen::Vector2d pixel(number_in(table, row, 1, "u"), number_in(table, row, 2, "v"));
    sightings.push_back({row.fields[0], row.fields[3], pixel, row.fields[4]});
  }
  return sightings;
}

}  // namespace raybundle
