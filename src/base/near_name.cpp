#include "base/near_name.h"

#include <algorithm>
#include <cctype>
#include <numeric>

namespace kinora {

namespace {

// Edits without case from one word to the other.
size_t distance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t(0));
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      const bool same =
          std::tolower(static_cast<unsigned char>(a[i - 1])) == std::tolower(static_cast<unsigned char>(b[j - 1]));
      const size_t edited = std::min({row[j] + 1, row[j - 1] + 1, diagonal + (same ? 0 : 1)});
      diagonal = row[j];
      row[j] = edited;
    }
  }
  return row.back();
}

}  // namespace

std::string didYouMean(const std::string& name, const std::vector<std::string>& names) {
  const std::string* best = nullptr;
  size_t least = std::max<size_t>(1, name.size() / 3) + 1;
  for (const std::string& n : names)
    if (const size_t d = distance(name, n); d < least) {
      least = d;
      best = &n;
    }
  return best ? "did you mean " + *best + "?" : std::string();
}

}  // namespace kinora
