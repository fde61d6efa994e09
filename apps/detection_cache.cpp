// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "detection_cache.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "raybundle/geometry/error.hpp"
#include "raybundle/io/hash.hpp"
#include "raybundle/scene/atomic_file.hpp"
#include "raybundle/targets/board_file.hpp"

namespace raybundle::apps {
namespace {

constexpr int kDetectorVersion = 4;  // raise it with every change of what a detector returns

using Json = nlohmann::json;

Json json_from(const Detection& detection) {
  Json points = Json::array();
  for (const Observation& o : detection.observations)
    points.push_back({o.point_id, o.pixel.x(), o.pixel.y(), o.sigma_px});
  return {{"hint", detection.hint}, {"seen_size", detection.seen_size}, {"points", points}};
}

Detection detection_from(const Json& json) {
  Detection detection;
  detection.hint = json.at("hint").get<std::string>();
  detection.seen_size = json.at("seen_size").get<std::string>();
  for (const Json& p : json.at("points")) {
    detection.observations.push_back(
        {p.at(0).get<int>(), {p.at(1).get<double>(), p.at(2).get<double>()}, p.at(3).get<double>()});
  }
  return detection;
}

std::filesystem::path entry_path(const std::string& key) {
  return std::filesystem::path(cache_folder()) / (key + ".json");
}

}  // namespace

std::string cache_key(const std::string& file_sha256, const std::vector<Board>& boards) {
  std::string text = "raybundle detections " + std::to_string(kDetectorVersion) + "\n" + file_sha256 + "\n";
  for (const Board& board : boards) text += word_of(board) + "\n";
  return sha256_of_bytes(text);
}

std::string cache_folder() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  const std::filesystem::path base = cache != nullptr && *cache != '\0' ? std::filesystem::path(cache)
                                     : home != nullptr                  ? std::filesystem::path(home) / ".cache"
                                                                        : std::filesystem::temp_directory_path();
  return (base / "raybundle" / "detections").string();
}

std::optional<std::vector<CachedFrame>> read_cached(const std::string& key) try {
  std::ifstream file(entry_path(key));
  if (!file) return std::nullopt;
  std::vector<CachedFrame> frames;
  for (const Json& json : Json::parse(file)) {
    CachedFrame frame{
        json.at("frame").get<std::string>(), json.at("width").get<int>(), json.at("height").get<int>(), {}};
    for (const Json& board : json.at("boards")) frame.boards.push_back(detection_from(board));
    frames.push_back(std::move(frame));
  }
  return frames;
} catch (const Json::exception&) {
  return std::nullopt;
}

void write_cached(const std::string& key, const std::vector<CachedFrame>& frames) {
  Json json = Json::array();
  for (const CachedFrame& frame : frames) {
    Json boards = Json::array();
    for (const Detection& detection : frame.boards) boards.push_back(json_from(detection));
    json.push_back({{"frame", frame.frame}, {"width", frame.width}, {"height", frame.height}, {"boards", boards}});
  }
  std::error_code ignored;
  std::filesystem::create_directories(cache_folder(), ignored);
  try {
    write_file_whole(entry_path(key), json.dump());
  } catch (const Error&) {
    return;
  }
}

}  // namespace raybundle::apps
