// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "label_groups.hpp"

#include <algorithm>
#include <limits>

#include "label_rules.hpp"

namespace raybundle {
namespace {

constexpr int kMostSteps = 20000;  // of the search in one group
constexpr int kMostRounds = 8;
constexpr double kNone = -std::numeric_limits<double>::infinity();

int root(std::vector<int>& group, int dot) {
  while (group[dot] != dot) dot = group[dot] = group[group[dot]];
  return dot;
}

// Links the unlabelled dots that have living candidates of one beam; `member` lists them group by group.
void link_dots(const LabelTask& task, LabelWork& work) {
  const auto all = task.candidates.all();
  work.group.resize(task.candidates.dots());
  for (int dot = 0; dot < task.candidates.dots(); ++dot) work.group[dot] = dot;
  for (std::size_t beam = 0; beam + 1 < work.first_of_beam.size(); ++beam) {
    int first = -1;
    for (int k = work.first_of_beam[beam]; k < work.first_of_beam[beam + 1]; ++k) {
      const int c = work.of_beam[k];
      if (!work.alive[c] || work.chosen[all[c].dot] >= 0) continue;
      if (first < 0) first = all[c].dot;
      work.group[root(work.group, all[c].dot)] = root(work.group, first);
    }
  }
  work.member.clear();
  for (int dot = 0; dot < task.candidates.dots(); ++dot) {
    if (work.chosen[dot] < 0 && !task.candidates.of_dot(dot).empty()) work.member.push_back(dot);
  }
  for (const int dot : work.member) work.group[dot] = root(work.group, dot);
  std::sort(work.member.begin(), work.member.end(),
            [&](int a, int b) { return std::pair(work.group[a], a) < std::pair(work.group[b], b); });
}

/// Tries the labels of a group's dots one after the other.
class GroupSearch {
 public:
  GroupSearch(const LabelTask& task, LabelWork& work, std::span<const int> dots, double sure_by)
      : task_(task), work_(work), dots_(dots), sure_by_(sure_by) {
    for (const int dot : dots) {
      work_.no_beam[dot] = kNone;
      for (int c = first(dot); c < last(dot); ++c) work_.next_weight[c] = kNone;
    }
  }

  /// Whether it came to an end. Then next_weight of a candidate, and no_beam of a dot, is the value of the best set
  /// with it, as far as that is within `sure_by` of best().
  bool run() {
    descend(0, 0.0, bound_from(0));
    return steps_ <= kMostSteps;
  }

  double best() const { return best_; }

 private:
  int first(int dot) const { return task_.candidates.first_of_dot(dot); }
  int last(int dot) const { return task_.candidates.first_of_dot(dot + 1); }

  // The most that a dot can add, whatever the others do.
  double most_of(int dot) const {
    double most = 0.0;
    for (int c = first(dot); c < last(dot); ++c) {
      if (work_.alive[c]) most = std::max(most, work_.weight[c]);
    }
    return most;
  }

  double bound_from(std::size_t i) const {
    double bound = 0.0;
    for (; i < dots_.size(); ++i) bound += most_of(dots_[i]);
    return bound;
  }

  bool allowed(int c) const {
    const auto all = task_.candidates.all();
    if (!work_.alive[c] || work_.dot_of_beam[all[c].beam] >= 0) return false;
    for (const int dot : dots_) {
      if (work_.chosen[dot] >= 0 && !in_order(task_, all[work_.chosen[dot]], all[c])) return false;
    }
    return true;
  }

  void record(double value) {
    best_ = std::max(best_, value);
    for (const int dot : dots_) {
      double& of_choice = work_.chosen[dot] >= 0 ? work_.next_weight[work_.chosen[dot]] : work_.no_beam[dot];
      of_choice = std::max(of_choice, value);
    }
  }

  // `rest` is the most that the dots from i on can add.
  void descend(std::size_t i, double value, double rest) {
    if (++steps_ > kMostSteps || value + rest < best_ - sure_by_) return;
    if (i == dots_.size()) {
      record(value);
      return;
    }
    const int dot = dots_[i];
    const double remaining = rest - most_of(dot);
    for (int c = first(dot); c < last(dot); ++c) {
      if (!allowed(c)) continue;
      choose(task_, work_, c);
      descend(i + 1, value + work_.weight[c], remaining);
      withdraw(task_, work_, dot);
    }
    descend(i + 1, value, remaining);
  }

  const LabelTask& task_;
  LabelWork& work_;
  std::span<const int> dots_;
  double sure_by_;
  double best_ = 0.0;
  int steps_ = 0;
};

// The candidate that all sets within reach of the best agree on, or -1.
int agreed(const LabelTask& task, const LabelWork& work, int dot, double reach) {
  int found = -1;
  bool others = work.no_beam[dot] >= reach;
  for (int c = task.candidates.first_of_dot(dot); c < task.candidates.first_of_dot(dot + 1); ++c) {
    if (work.next_weight[c] < reach) continue;
    others |= found >= 0;
    found = c;
  }
  return others ? -1 : found;
}

void weigh(const LabelTask& task, LabelWork& work, const SetValue& value) {
  const auto all = task.candidates.all();
  work.weight.resize(all.size());
  for (std::size_t c = 0; c < all.size(); ++c) {
    work.weight[c] = value.of_label + (value.of_weight > 0.0 ? value.of_weight * weight_of(task, work, all[c]) : 0.0);
  }
}

// Searches each group and chooses what its best sets agree on; whether there was anything.
bool choose_agreed(const LabelTask& task, LabelWork& work, double sure_by) {
  work.next_weight.resize(task.candidates.all().size());
  work.no_beam.resize(task.candidates.dots());
  bool any = false;
  for (std::size_t begin = 0, end = 0; begin < work.member.size(); begin = end) {
    while (end < work.member.size() && work.group[work.member[end]] == work.group[work.member[begin]]) ++end;
    const std::span<const int> dots = std::span(work.member).subspan(begin, end - begin);
    GroupSearch search(task, work, dots, sure_by);
    if (!search.run()) continue;
    const double reach = search.best() - sure_by;
    for (const int dot : dots) {
      const int c = agreed(task, work, dot, reach);
      if (c < 0) continue;
      choose(task, work, c);
      any = true;
    }
  }
  return any;
}

}  // namespace

void choose_best_sets(const LabelTask& task, LabelWork& work, const SetValue& value) {
  begin(task, work);
  index_by_beam(task, work);
  choose_unrivalled(task, work);
  for (int round = 0; round < kMostRounds; ++round) {
    rule_out(task, work);
    weigh(task, work, value);
    link_dots(task, work);
    if (!choose_agreed(task, work, value.sure_by)) break;
  }
  withdraw_doubtful(task, work);
}

void maximal_cliques(const LabelTask& task, LabelWork& work) {
  choose_best_sets(task, work, {.of_label = 1.0, .of_weight = 0.0, .sure_by = 0.5});
}

void maximum_set(const LabelTask& task, LabelWork& work) {
  choose_best_sets(task, work, {.of_label = kBeamOverClutter, .of_weight = 1.0, .sure_by = kSureBy});
}

}  // namespace raybundle
