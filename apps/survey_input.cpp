// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "survey_input.hpp"

#include <optional>

#include "number_flags.hpp"
#include "raybundle/io/survey_files.hpp"
#include "raybundle/scene/csv.hpp"

namespace raybundle::apps {

void add_survey_flags(CLI::App& verb, bool required, SurveyInput& input) {
  CLI::Option* landmarks = verb.add_option("--landmarks", input.landmarks,
                                           "CSV whose header is name,lat,lon,height,sigma or name,east,north,up,sigma "
                                           "or name,azimuth,elevation,sigma (degrees, metres)")
                               ->type_name("FILE");
  CLI::Option* sightings =
      verb.add_option("--sightings", input.sightings, "CSV: image,u,v,name and, of several cameras, camera")
          ->type_name("FILE");
  landmarks->required(required)->needs(sightings);
  sightings->required(required)->needs(landmarks);
  verb.add_option("--origin", input.origin,
                  "of the local frame: latitude, longitude [deg], height above the ellipsoid [m]")
      ->delimiter(',')
      ->expected(3)
      ->needs(landmarks)
      ->check(finite_number)
      ->type_name("LAT,LON,HEIGHT");
  verb.add_option("--height", input.height,
                  "what heights are above: ellipsoidal, or orthometric:N with the geoid's height N there [m]")
      ->needs(landmarks)
      ->type_name("DATUM");
  verb.add_option("--sighting-sigma", input.sigma_px, "of a sighting's u and v [px]")
      ->check(above_zero)
      ->needs(landmarks)
      ->capture_default_str();
}

Survey read_survey(const SurveyInput& input) {
  std::optional<Geodetic> origin;
  if (!input.origin.empty()) origin = Geodetic{input.origin[0], input.origin[1], input.origin[2]};
  std::optional<HeightDatum> datum;
  if (!input.height.empty()) datum = height_datum_from_word(input.height);
  Survey survey;
  survey.landmarks = landmarks_from_csv_text(text_of_file(input.landmarks), input.landmarks, origin, datum);
  survey.sightings = sightings_from_csv_text(text_of_file(input.sightings), input.sightings, survey.landmarks);
  survey.sighting_sigma_px = input.sigma_px;
  return survey;
}

}  // namespace raybundle::apps
