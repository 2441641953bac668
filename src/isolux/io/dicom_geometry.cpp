#include "isolux/io/dicom_geometry.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "isolux/base/error.h"
#include "isolux/io/placement_fault.h"

namespace isolux {
namespace {

constexpr double kPi = 3.14159265358979323846;
// Positions are written with few digits; a step may differ by this share and still be regular.
constexpr double kRegular = 0.02;
// Unequal steps are told from multiples of one step by this share.
constexpr double kMultiple = 0.1;
// Beyond this many steps, what lies between two slices is not known well enough to be mixed.
constexpr double kWidestGap = 10;
constexpr double kWidestUnequalGap = 4;
constexpr double kSamePlace_mm = 1e-3;

std::string mm(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g mm", value);
  return text;
}

std::string count_text(std::size_t count, const std::string& one, const std::string& many) {
  return count == 1 ? "1 " + one : std::to_string(count) + " " + many;
}

// --- Groups of slices that can be one stack ---

bool are_near(double a, double b) { return std::fabs(a - b) <= 1e-3 * std::fabs(a); }

bool are_parallel(Vec3 a, Vec3 b) { return dot(a, b) > 1 - 1e-4; }  // within 0.8 degrees

bool belong_together(const SlicePlace& a, const SlicePlace& b) {
  if (a.columns != b.columns || a.rows != b.rows) return false;
  if (a.position.has_value() != b.position.has_value()) return false;
  if (a.axes.has_value() != b.axes.has_value()) return false;
  if (a.spacing_mm.has_value() != b.spacing_mm.has_value()) return false;
  if (a.axes &&
      !(are_parallel((*a.axes)[0], (*b.axes)[0]) && are_parallel((*a.axes)[1], (*b.axes)[1]))) {
    return false;
  }
  return !a.spacing_mm || (are_near((*a.spacing_mm)[0], (*b.spacing_mm)[0]) &&
                           are_near((*a.spacing_mm)[1], (*b.spacing_mm)[1]));
}

using Numbers = std::vector<std::size_t>;

Numbers largest_group(const std::vector<SlicePlace>& slices, std::vector<std::string>& notes) {
  std::vector<Numbers> groups;
  for (std::size_t n = 0; n < slices.size(); ++n) {
    const auto group = std::ranges::find_if(
        groups, [&](const Numbers& g) { return belong_together(slices[g.front()], slices[n]); });
    if (group != groups.end()) {
      group->push_back(n);
    } else {
      groups.push_back({n});
    }
  }
  const auto largest =
      std::ranges::max_element(groups, {}, [](const Numbers& group) { return group.size(); });
  if (groups.size() > 1) {
    const std::size_t others = slices.size() - largest->size();
    notes.push_back(std::to_string(others) + " of its " + std::to_string(slices.size()) +
                    " slices differ in size, orientation or spacing from the others (localizers?)"
                    ": left out");
  }
  return *largest;
}

// --- The frame of one slice ---

struct Frame {
  Vec3 along_i, along_j, normal;  // unit vectors
  double spacing_i = 1, spacing_j = 1;
};

Frame frame_of(const std::string& name, const SlicePlace& slice, std::vector<std::string>& notes) {
  Frame frame{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  if (slice.axes) {
    const auto& [i, j] = *slice.axes;
    const double length_i = length(i), length_j = length(j), length_n = length(cross(i, j));
    const bool is_sound = std::fabs(length_i - 1) < 0.1 && std::fabs(length_j - 1) < 0.1 &&
                          length_n > 0.9 * length_i * length_j;
    if (!is_sound) {
      throw WorkError(name, "its orientation is not two perpendicular unit vectors",
                      "mend its ImageOrientationPatient");
    }
    frame.along_i = i / length_i;
    frame.along_j = j / length_j;
    frame.normal = normalize(cross(i, j));
  } else if (slice.position) {
    notes.push_back("the files give no orientation: rows to the left, columns to posterior");
  }
  if (!slice.spacing_mm) {
    notes.push_back("the files give no pixel spacing: 1 mm was taken");
    return frame;
  }
  frame.spacing_i = (*slice.spacing_mm)[0];
  frame.spacing_j = (*slice.spacing_mm)[1];
  const auto is_sound = [](double s) { return std::isfinite(s) && s > 0; };
  if (!is_sound(frame.spacing_i) || !is_sound(frame.spacing_j)) {
    throw WorkError(name, "its pixel spacing is not positive", "mend its PixelSpacing");
  }
  return frame;
}

double told_distance(const SlicePlace& slice, std::vector<std::string>& notes) {
  const double told = slice.distance_mm.value_or(0);
  if (std::isfinite(told) && told != 0) return std::fabs(told);
  notes.push_back("the files give no distance between slices: 1 mm was taken");
  return 1;
}

void place_grid(const Frame& frame, Vec3 origin, Vec3 step, SliceStack& stack) {
  stack.world_from_index.linear = {
      {frame.spacing_i * frame.along_i, frame.spacing_j * frame.along_j, step}};
  stack.world_from_index.offset = origin;
}

// --- Places along the normal ---

struct Place {
  double along_mm;  // the slices' distance from the world origin's plane
  Numbers slices;
};

std::vector<Place> ascending_places(const std::vector<SlicePlace>& slices, const Numbers& group,
                                    Vec3 normal) {
  std::vector<Place> all;
  for (const std::size_t n : group) all.push_back({dot(*slices[n].position, normal), {n}});
  std::ranges::stable_sort(all, {}, &Place::along_mm);
  std::vector<Place> places;
  for (const Place& place : all) {
    if (!places.empty() && place.along_mm - places.back().along_mm <= kSamePlace_mm) {
      places.back().slices.push_back(place.slices.front());
    } else {
      places.push_back(place);
    }
  }
  for (Place& place : places) std::ranges::sort(place.slices);
  return places;
}

void settle_duplicates(std::vector<Place>& places, std::vector<std::string>& notes) {
  const std::size_t most = std::ranges::max_element(places, {}, [](const Place& p) {
                             return p.slices.size();
                           })->slices.size();
  const bool all_alike =
      std::ranges::all_of(places, [&](const Place& p) { return p.slices.size() == most; });
  if (most == 1) return;
  if (all_alike) {
    notes.push_back("each place has " + std::to_string(most) +
                    " slices (time points, echoes or copies): each is a volume");
    return;
  }
  std::size_t dropped = 0;
  for (Place& place : places) {
    dropped += place.slices.size() - 1;
    place.slices.resize(1);
  }
  notes.push_back(count_text(dropped, "slice lies", "slices lie") +
                  " where another does: the first of each place was kept");
}

// --- Layers ---

struct Spacing {
  double step_mm;
  std::vector<double> index;  // of each place on the grid
};

std::vector<double> gaps_between(const std::vector<Place>& places) {
  std::vector<double> gaps;
  for (std::size_t k = 1; k < places.size(); ++k) {
    gaps.push_back(places[k].along_mm - places[k - 1].along_mm);
  }
  return gaps;
}

std::optional<Spacing> regular(const std::vector<Place>& places) {
  const double step =
      (places.back().along_mm - places.front().along_mm) / static_cast<double>(places.size() - 1);
  Spacing spacing{step, {}};
  for (std::size_t k = 0; k < places.size(); ++k) {
    const double expected = places.front().along_mm + static_cast<double>(k) * step;
    if (std::fabs(places[k].along_mm - expected) > kRegular * step) return std::nullopt;
    spacing.index.push_back(static_cast<double>(k));
  }
  return spacing;
}

// The steps as whole multiples of one step.
std::optional<Spacing> with_missing_slices(const std::vector<double>& gaps, double usual) {
  const double smallest = std::ranges::min(gaps);
  if (smallest < usual / 4) return std::nullopt;
  double sum = 0, count = 0;
  for (const double gap : gaps) {
    if (gap > smallest * (1 + kMultiple)) continue;
    sum += gap;
    ++count;
  }
  const double step = sum / count;
  Spacing spacing{step, {0}};
  for (const double gap : gaps) {
    const double multiple = std::round(gap / step);
    if (std::fabs(gap / step - multiple) > kMultiple) return std::nullopt;
    spacing.index.push_back(spacing.index.back() + multiple);
  }
  spacing.step_mm = std::accumulate(gaps.begin(), gaps.end(), 0.0) / spacing.index.back();
  return spacing;
}

Spacing unequal(const std::vector<double>& gaps, double usual) {
  const double total = std::accumulate(gaps.begin(), gaps.end(), 0.0);
  Spacing spacing{total / std::fmax(1, std::round(total / usual)), {0}};
  double along = 0;
  for (const double gap : gaps) spacing.index.push_back((along += gap) / spacing.step_mm);
  spacing.index.back() = std::round(spacing.index.back());
  return spacing;
}

std::vector<Layer> layers_of(const std::vector<double>& index) {
  constexpr double kOnASlice = 1e-6;
  std::vector<Layer> layers;
  const auto count = static_cast<std::size_t>(std::lround(index.back())) + 1;
  std::size_t lower = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const auto at = static_cast<double>(k);
    while (lower + 1 < index.size() && index[lower + 1] <= at + kOnASlice) ++lower;
    const double beyond = at - index[lower];
    if (lower + 1 == index.size() || beyond <= kOnASlice) {
      layers.push_back({lower, lower, 0});
    } else {
      layers.push_back({lower, lower + 1, beyond / (index[lower + 1] - index[lower])});
    }
  }
  return layers;
}

// The gaps wider than `least`, by where they lie.
std::string named_gaps(const std::vector<Place>& places, double least) {
  constexpr int kMost = 4;
  std::string text;
  int named = 0, more = 0;
  for (std::size_t k = 1; k < places.size(); ++k) {
    const double from = places[k - 1].along_mm, to = places[k].along_mm;
    if (to - from <= least) continue;
    if (named == kMost) {
      ++more;
      continue;
    }
    text += (named++ == 0 ? "" : ", ") + mm(to - from) + " from " + mm(from) + " to " + mm(to);
  }
  return more == 0 ? text : text + " and " + std::to_string(more) + " more";
}

Spacing spacing_of(const std::string& name, const std::vector<Place>& places,
                   std::vector<std::string>& notes) {
  if (const auto spacing = regular(places)) return *spacing;
  const std::vector<double> gaps = gaps_between(places);
  std::vector<double> sorted = gaps;
  std::ranges::sort(sorted);
  const double usual = sorted[sorted.size() / 2];
  const double widest = sorted.back();
  const auto refuse = [&]() {
    throw WorkError(name,
                    "its slices are too irregular to be one volume: they lie " + mm(usual) +
                        " apart, but there are gaps of " + named_gaps(places, 1.5 * usual),
                    "are files missing, or several scans mixed?");
  };
  if (const auto spacing = with_missing_slices(gaps, usual)) {
    if (widest > kWidestGap * usual) refuse();
    notes.push_back("slices are missing: gaps of " +
                    named_gaps(places, (1 + kMultiple) * spacing->step_mm) +
                    " along their normal were filled linearly, " + mm(spacing->step_mm) + " apart");
    return *spacing;
  }
  if (widest > kWidestUnequalGap * usual) refuse();
  const Spacing spacing = unequal(gaps, usual);
  const std::string wide = named_gaps(places, std::fmax(1.1 * usual, (usual + widest) / 2));
  notes.push_back("slices lie unequally far apart, " + mm(sorted.front()) + " to " + mm(widest) +
                  ": resampled linearly to " + mm(spacing.step_mm) +
                  (wide.empty() ? "" : "; the widest gaps are " + wide));
  return spacing;
}

// --- Sideways steps ---

// The mm that slices step sideways for each mm along the normal.
Vec3 slope_of(const std::string& name, const std::vector<Vec3>& positions,
              const std::vector<Place>& places, const Frame& frame,
              std::vector<std::string>& notes) {
  const double along = places.back().along_mm - places.front().along_mm;
  const Vec3 step = (positions.back() - positions.front()) / along;
  const Vec3 sideways = step - frame.normal;
  double farthest = 0;
  for (std::size_t k = 0; k < places.size(); ++k) {
    const double from_first = places[k].along_mm - places.front().along_mm;
    farthest = std::fmax(farthest, length(positions[k] - positions.front() - from_first * step));
  }
  const double voxel = std::fmax(frame.spacing_i, frame.spacing_j);
  if (farthest > 3 * voxel) {
    throw WorkError(name, "its slices do not lie in line: one is " + mm(farthest) + " off",
                    "are several scans mixed?");
  }
  if (farthest > 0.5 * voxel) {
    notes.push_back("slices lie up to " + mm(farthest) + " sideways of their line: left so");
  }
  const double angle_deg = std::atan(length(sideways)) * 180 / kPi;
  if (angle_deg >= 0.1) {
    char text[96];
    std::snprintf(text, sizeof text,
                  angle_deg >= 1 ? "%.1f° gantry tilt: kept as shear"
                                 : "the slices' step leans %.1f° off their normal: kept as shear",
                  angle_deg);
    notes.push_back(text);
  }
  return step;
}

void stack_placed(const std::string& name, const std::vector<SlicePlace>& slices,
                  const Numbers& group, SliceStack& stack) {
  const SlicePlace& first = slices[group.front()];
  const Frame frame = frame_of(name, first, stack.notes);
  for (const std::size_t n : group) {
    if (!is_finite(*slices[n].position)) {
      throw WorkError(name, "a slice's position is not finite", "mend its ImagePositionPatient");
    }
  }
  std::vector<Place> places = ascending_places(slices, group, frame.normal);
  settle_duplicates(places, stack.notes);
  std::vector<Vec3> positions;
  for (const Place& place : places) {
    stack.places.push_back(place.slices);
    positions.push_back(*slices[place.slices.front()].position);
  }
  if (places.size() == 1) {
    stack.layers = {Layer{}};
    place_grid(frame, positions[0], told_distance(first, stack.notes) * frame.normal, stack);
    return;
  }
  const Spacing spacing = spacing_of(name, places, stack.notes);
  const Vec3 slope = slope_of(name, positions, places, frame, stack.notes);
  stack.layers = layers_of(spacing.index);
  stack.is_resampled = stack.layers.size() != places.size() ||
                       std::ranges::any_of(stack.layers, [](const Layer& layer) {
                         return layer.share_of_upper != 0;
                       });
  place_grid(frame, positions[0], spacing.step_mm * slope, stack);
}

void stack_unplaced(const std::string& name, const std::vector<SlicePlace>& slices,
                    const Numbers& group, SliceStack& stack) {
  const SlicePlace& first = slices[group.front()];
  stack.notes.push_back(
      "the files do not say how they lie in the patient: slices are stacked in their order, rows "
      "to the left, columns to posterior");
  const Frame frame = frame_of(name, first, stack.notes);
  for (const std::size_t n : group) {
    stack.layers.push_back({stack.places.size(), stack.places.size(), 0});
    stack.places.push_back({n});
  }
  place_grid(frame, {}, told_distance(first, stack.notes) * frame.normal, stack);
}

}  // namespace

SliceStack stack_slices(const std::string& name, const std::vector<SlicePlace>& slices) {
  SliceStack stack;
  const Numbers group = largest_group(slices, stack.notes);
  const bool is_placed = slices[group.front()].position.has_value();
  (is_placed ? stack_placed : stack_unplaced)(name, slices, group, stack);
  if (const std::string fault = placement_fault(stack.world_from_index); !fault.empty()) {
    throw WorkError(name, "its placement " + fault, "mend its header");
  }
  return stack;
}

}  // namespace isolux
