// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>

namespace raybundle::apps {

/// Thrown by a verb that did its job but whose answer is no: a quality gate failed.
struct GateFailed {};

void add_target_verb(CLI::App& app);
void add_detect_verb(CLI::App& app);
void add_calibrate_verb(CLI::App& app);
void add_validate_verb(CLI::App& app);
void add_compare_verb(CLI::App& app);
void add_survey_verb(CLI::App& app);
void add_report_verb(CLI::App& app);
void add_project_verb(CLI::App& app);
void add_unproject_verb(CLI::App& app);
void add_simulate_verb(CLI::App& app);
void add_simulate_cockpit_verb(CLI::App& app);
void add_export_verb(CLI::App& app);
void add_import_verb(CLI::App& app);
void add_reconstruct_verb(CLI::App& app);
void add_occupancy_verb(CLI::App& app);
void add_eye_safety_verb(CLI::App& app);
void add_demo_verb(CLI::App& app);
void add_doctor_verb(CLI::App& app);

/// The one list of verbs, in the order of --help.
inline constexpr void (*kVerbs[])(CLI::App&) = {
    add_target_verb,           add_detect_verb, add_calibrate_verb, add_validate_verb,    add_compare_verb,
    add_survey_verb,           add_report_verb, add_project_verb,   add_unproject_verb,   add_simulate_verb,
    add_simulate_cockpit_verb, add_export_verb, add_import_verb,    add_reconstruct_verb, add_occupancy_verb,
    add_eye_safety_verb,       add_demo_verb,   add_doctor_verb};

}  // namespace raybundle::apps
