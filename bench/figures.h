// The figures of a run: medians with their spread, printed as a table and written as flat JSON. Used by every family
// of kinora-bench; it measures nothing itself.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "base/elapsed.h"

namespace kinora::bench {

// Seconds of a monotonic clock, and of this thread's and this process' CPU time: what other work on the machine takes
// from a single-threaded measure shows in the first only.
double wallSeconds();
using kinora::threadSeconds;
double processSeconds();

double median(std::vector<double> v);  // 0 when empty

struct Figure {
  std::string name, meaning;
  double value = 0, min = 0, max = 0;
};

class Figures {
 public:
  // One figure from its repetitions: the median, the least and the largest.
  void add(const std::string& name, const std::vector<double>& repetitions, const std::string& meaning);
  // What was measured is not what it should be, so that the figures mean nothing: said on stderr with a code, and the
  // program ends with 1.
  void fail(const std::string& code, const std::string& what);
  bool isSound() const { return isSound_; }
  const std::vector<Figure>& list() const { return list_; }
  void print() const;
  // {"name": .., "name_min": .., "name_max": ..}; false when the file cannot be written.
  bool writeJson(const std::string& file) const;

 private:
  std::vector<Figure> list_;
  bool isSound_ = true;
};

}  // namespace kinora::bench
