// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "usage_error.hpp"

#include <fmt/format.h>

#include <vector>

#include "raybundle/scene/csv.hpp"
#include "raybundle/scene/suggestion.hpp"

namespace raybundle::apps {
namespace {

std::string no_such_verb(const CLI::App& app, const std::string& word) {
  std::vector<std::string> verbs;
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; })) {
    verbs.push_back(verb->get_name());
  }
  if (word.empty()) return fmt::format("which verb?{} `raybundle --help` explains them", did_you_mean("", verbs));
  return fmt::format("there is no verb {}.{}", in_quotes(word), did_you_mean(word, verbs));
}

std::string no_such_flag(const CLI::App& verb, const std::string& command, const std::string& word) {
  std::vector<std::string> flags;
  for (const CLI::Option* option : verb.get_options()) {
    for (const std::string& name : option->get_lnames()) flags.push_back("--" + name);
  }
  const std::optional<std::string> near = closest(word.substr(0, word.find('=')), flags);
  return fmt::format("{} has no flag {}{}", command, in_quotes(word),
                     near ? fmt::format(". Did you mean \"{}\"?", *near)
                          : fmt::format("; `{} --help` lists those there are", command));
}

}  // namespace

std::string usage_message(const CLI::App& app, const CLI::ParseError& error) {
  const auto parsed = [](const CLI::App* verb) { return verb->parsed(); };
  const std::vector<const CLI::App*> verbs = app.get_subcommands(parsed);
  const std::vector<std::string> unknown = app.remaining(true);
  if (verbs.empty()) return no_such_verb(app, unknown.empty() ? "" : unknown.front());
  std::string command = "raybundle";
  const CLI::App* verb = nullptr;
  for (auto below = verbs; !below.empty();
       below = verb->get_subcommands(parsed)) {  // some verbs have verbs of their own
    verb = below.front();
    command += " " + verb->get_name();
  }
  if (error.get_exit_code() != static_cast<int>(CLI::ExitCodes::ExtrasError) || unknown.empty()) {
    return fmt::format("{}: {}; see `{} --help`", command, error.what(), command);
  }
  const std::string& word = unknown.front();
  if (word.starts_with('-')) return no_such_flag(*verb, command, word);
  return fmt::format("{} does not know what to do with {}; patterns of images stand in quotes, as in left='left*.jpg'",
                     command, in_quotes(word));
}

}  // namespace raybundle::apps
