#pragma once

#include <functional>
#include <string>
#include <vector>

namespace isolux {

/// How long one call takes, in ms of the wall's clock.
double milliseconds(const std::function<void()>& work);

/// The middle value; of an even number, the mean of the middle two. `values` must not be empty.
double median(std::vector<double> values);

/// The least value that 99 % of them do not exceed (nearest rank): below 100 values the greatest.
double percentile_99(std::vector<double> values);

/// How many tasks wanted to run, on average over the last minute (/proc/loadavg); -1: unknown.
double load_average();

/// What the machine's processor calls itself (/proc/cpuinfo); empty: unknown.
std::string processor_name();

}  // namespace isolux
