// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "raybundle/bundle/bundle.hpp"
#include "raybundle/scene/problem.hpp"

namespace raybundle {

/// Whether a model's radial profile has a denominator, and so can have a pole. Where a polynomial turns back all
/// corners tell together, and rightly.
bool can_have_pole(ModelId model);

/// Whether a camera's lens of a rational model ends among its corners (in use, or not projected by it) or hardly beyond
/// them: its radial profile has a pole within 1.22 times their radius in the plane, or turns back within 1.02 times
/// their angle. Such a lens can
/// fit the corners better than any real one, with a spike between two of them. Models without a denominator have no
/// spikes, and false is returned.
bool ends_among_corners(const CalibrationProblem& problem, const BundleState& state, int camera);

/// Whether only the later of two states of a problem with one camera has a lens that ends among its corners.
bool spoils_lens(const CalibrationProblem& single, const BundleState& before, const BundleState& after);

/// Brings a problem and a state to an optimum.
using SolveFunction = std::function<BundleSummary(const CalibrationProblem& problem, BundleState& state)>;

/// Replaces a solved lens that ends among its corners by one that does not. The free coefficients of its radial profile
/// are held at zero one after the other, the last first (k6, then k5, ...), until the lens reaches beyond its corners;
/// then they are let go again from there, as far as it stays so: mostly the first one was enough, and sometimes there
/// is a lens with all of them beside the one that was found. Nothing changes when only a lens that fits plainly worse
/// would do.
///
/// @param problem  gets a rule for each coefficient that stays at zero
/// @param summary  of the solve that led to the state, then of the last one
/// @return         whether the state changed
bool give_up_coefficients(CalibrationProblem& problem, BundleState& state, int camera, BundleSummary& summary,
                          const SolveFunction& solve);

}  // namespace raybundle
