#include "app/frame_list.h"

#include <algorithm>
#include <charconv>

namespace kinora::app {

std::optional<FrameList> FrameList::parse(const std::string& text) {
  FrameList list;
  const char *at = text.data(), *end = at + text.size();
  const auto number = [&](int& value) {
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || next == at) return false;
    at = next;
    return true;
  };
  for (;;) {
    std::pair<int, int> range;
    if (!number(range.first)) return std::nullopt;
    range.second = range.first;
    if (at != end && *at == '-') {
      ++at;
      if (!number(range.second) || range.second < range.first) return std::nullopt;
    }
    list.ranges_.push_back(range);
    if (at == end) return list;
    if (*at++ != ',') return std::nullopt;
  }
}

bool FrameList::holds(int frame) const {
  return isAll() || std::any_of(ranges_.begin(), ranges_.end(),
                                [&](const auto& r) { return frame >= r.first && frame <= r.second; });
}

std::string FrameList::missing(const std::set<int>& met) const {
  std::string text;
  int named = 0;
  for (const auto& [first, last] : ranges_)
    for (int64_t f = first; f <= last; ++f) {
      if (met.contains(int(f))) continue;
      constexpr int kMost = 5;
      if (named++ == kMost) return text + " ...";
      text += (text.empty() ? "" : ", ") + std::to_string(f);
    }
  return text;
}

}  // namespace kinora::app
