#pragma once

#include <cstdint>

#include "isolux/io/reader.h"

namespace isolux {

/// Which of the file's result.volume_count volumes the request's grid asks for, counted from 0; a
/// note tells where there is a choice.
/// @throws UsageError  where there is none of that number.
std::uint64_t chosen_volume(const ReadRequest& request, ReadResult& result);

}  // namespace isolux
