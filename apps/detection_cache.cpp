// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "detection_cache.hpp"

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>

#include "raybundle/geometry/error.hpp"
#include "raybundle/io/hash.hpp"
#include "raybundle/scene/atomic_file.hpp"
#include "raybundle/targets/board_file.hpp"

namespace raybundle::apps {
namespace {

namespace fs = std::filesystem;

constexpr int kDetectorVersion = 10;  // raise it with every change of what a detector returns

using Json = nlohmann::json;
using Days = std::chrono::days;

Json json_from(const Detection& detection) {
  Json points = Json::array();
  for (const Observation& o : detection.observations)
    points.push_back({o.point_id, o.pixel.x(), o.pixel.y(), o.sigma_px});
  return {{"hint", detection.hint}, {"seen_size", detection.seen_size}, {"points", points}};
}

// What is damaged throws: a wrong type Json::exception, a wrong value Damaged.
struct Damaged {};

void require(bool law) {
  if (!law) throw Damaged{};
}

Detection detection_from(const Json& json, const Target& target) {
  Detection detection;
  detection.hint = json.at("hint").get<std::string>();
  detection.seen_size = json.at("seen_size").get<std::string>();
  std::set<int> ids;
  for (const Json& p : json.at("points")) {
    require(p.is_array() && p.size() == 4);
    const Observation o{{p.at(1).get<double>(), p.at(2).get<double>()}, p.at(3).get<double>(), p.at(0).get<int>()};
    require(o.pixel.allFinite() && o.sigma_px > 0 && target.find(o.point_id) != nullptr &&
            ids.insert(o.point_id).second);
    detection.observations.push_back(o);
  }
  return detection;
}

fs::path entry_path(const std::string& key) { return fs::path(cache_folder()) / (key + ".json"); }

// Since it was written or used: an entry's time says when, to a day.
auto time_unused(const fs::path& entry) {
  std::error_code gone;  // its time is then long ago
  return fs::file_time_type::clock::now() - fs::last_write_time(entry, gone);
}

void note_use(const fs::path& entry) {
  std::error_code ignored;
  if (time_unused(entry) > Days(1)) fs::last_write_time(entry, fs::file_time_type::clock::now(), ignored);
}

// Whatever lies in the folder: what killed runs did not finish, too.
void delete_unused() {
  std::error_code failed, ignored;
  for (fs::directory_iterator entry(cache_folder(), failed), end; !failed && entry != end; entry.increment(failed)) {
    if (time_unused(entry->path()) > Days(kDaysInCache)) fs::remove(entry->path(), ignored);
  }
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
  const fs::path base = cache != nullptr && *cache != '\0' ? fs::path(cache)
                        : home != nullptr                  ? fs::path(home) / ".cache"
                                                           : fs::temp_directory_path();
  return (base / "raybundle" / "detections").string();
}

std::optional<std::vector<CachedFrame>> cached_from_text(std::string_view text, const std::vector<Board>& boards) try {
  std::vector<Target> targets;
  for (const Board& board : boards) targets.push_back(target_of(board));
  std::vector<CachedFrame> frames;
  for (const Json& json : Json::parse(text)) {
    CachedFrame frame{
        json.at("frame").get<std::string>(), json.at("width").get<int>(), json.at("height").get<int>(), {}};
    const Json& found = json.at("boards");
    require(frame.width > 0 && frame.height > 0 && found.is_array() && found.size() == targets.size());
    for (std::size_t b = 0; b < targets.size(); ++b) frame.boards.push_back(detection_from(found[b], targets[b]));
    frames.push_back(std::move(frame));
  }
  return frames;
} catch (const Json::exception&) {
  return std::nullopt;
} catch (const Damaged&) {
  return std::nullopt;
}

std::optional<std::vector<CachedFrame>> read_cached(const std::string& key, const std::vector<Board>& boards) {
  std::ifstream file(entry_path(key), std::ios::binary);
  if (!file) return std::nullopt;
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  note_use(entry_path(key));
  return cached_from_text(text, boards);
}

void write_cached(const std::string& key, const std::vector<CachedFrame>& frames) {
  Json json = Json::array();
  for (const CachedFrame& frame : frames) {
    Json boards = Json::array();
    for (const Detection& detection : frame.boards) boards.push_back(json_from(detection));
    json.push_back({{"frame", frame.frame}, {"width", frame.width}, {"height", frame.height}, {"boards", boards}});
  }
  static std::once_flag once;  // in a run
  std::call_once(once, delete_unused);
  std::error_code ignored;
  fs::create_directories(cache_folder(), ignored);
  try {
    write_file_whole(entry_path(key), json.dump(-1, ' ', false, Json::error_handler_t::replace));
  } catch (const Error&) {
    return;
  }
}

}  // namespace raybundle::apps
