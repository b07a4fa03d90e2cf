// The frames that --frames asks for. Used by the render command.
#pragma once
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace kinora::app {

class FrameList {
 public:
  // "1-100", "1,5,9", "1-10,20-30", negative numbers too ("-5--1"). Nothing when it is none of these.
  static std::optional<FrameList> parse(const std::string& text);
  bool isAll() const { return ranges_.empty(); }
  bool holds(int frame) const;
  bool isSingle() const { return ranges_.size() == 1 && ranges_[0].first == ranges_[0].second; }
  // Those of the list that are not in `met`, as text; at most a few. "" when there is none.
  std::string missing(const std::set<int>& met) const;

 private:
  std::vector<std::pair<int, int>> ranges_;  // both ends included
};

}  // namespace kinora::app
