#pragma once

#include <cstdint>
#include <span>

#include "isolux/intersect/iso_lanes.h"

// What iso_lanes.cpp and the code for each instruction set say to each other.

namespace isolux::lanes {

enum class VoxelType { kU8, kI16, kU16, kF32 };

/// All that the walk of a ray needs, in plain numbers.
struct Field {
  VoxelType type;
  const void* voxels;
  std::int32_t dims[3];
  bool is_wide;                ///< voxels lie further than 2^31 bytes apart
  const std::uint32_t* leaps;  ///< four bits an octant, as SkipGrid has them
  const std::uint32_t* cells;  ///< two words a block, the lower z first
  std::int32_t block_stride_y;
  std::int32_t block_stride_z;
  std::int32_t block_count;
  float iso;                        ///< the iso value, and
  float iso_rest;                   ///< what is missing from it to the double
  float doubt;                      ///< a field value within this of 0 has no certain sign
  float world_from_covector[3][3];  ///< row-major
};

/// What the walk found, with what the oracle needs where the lanes leave something to it.
struct Found {
  std::uint32_t hit = 0;
  std::uint32_t turned = 0;          ///< whose normal was turned round
  std::uint32_t undecided = 0;       ///< ask the oracle
  std::uint32_t without_normal = 0;  ///< ask the oracle for the normal
  alignas(64) std::int32_t cell[3][RayLanes::kCount];
  alignas(64) float local[3][RayLanes::kCount];
};

/// Rays that are asked for, and where the answer goes. Without `hits` the hits have no place and no
/// normal, but are the same.
struct Question {
  const RayLanes* rays;
  std::uint32_t lanes;
  HitLanes* hits;
  Found* found;
};

/// The code for the best instruction set allowed. The rays of all questions pass through the lanes
/// in one stream, so many together are quicker.
void walk(const Field& field, std::span<const Question> questions);
/// The same for lanes that run side by side.
void walk_beam(const Field& field, const RayLanes& rays, std::uint32_t lanes, HitLanes* hits,
               Found& found);

}  // namespace isolux::lanes
