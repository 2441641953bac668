#pragma once

#include <string>
#include <vector>

namespace isolux {

/// From now on in this process, headers may name data files anywhere.
void trust_headers();

/// Where a data file lies that a header names: beside the header or in a folder below it. A header
/// may come from anywhere; it is not to make isolux read (or tell the size of) other files.
/// @throws WorkError  where `named` is empty or, unless trust_headers() was called, is absolute or
/// leads elsewhere, by steps up ("..") or by links, or where there is no such file.
std::string data_file_beside(const std::string& header_path, const std::string& named);

/// "slice%03d.raw" for the numbers first, first + step, ... last. Nothing but %d, %Nd and %0Nd is
/// understood, whatever printf would make of it; empty where the pattern is not, or the numbers
/// make more than a million names.
std::vector<std::string> numbered_files(const std::string& pattern, long long first, long long last,
                                        long long step);

}  // namespace isolux
