// What the events of a light path do to the state of a camera path that it is connected to. Camera paths step a
// PathAutomaton event by event; the events of a light path come in the other order, from the light on. So a light path
// steps a tail: the function from states to states that its events, read from the last one back to the light, amount
// to (not from the start: paths are joined behind an event). Functions that end nowhere else are one, and only those
// that some path makes are there: the automaton of the expressions read backwards, for each state that a camera path
// may come with.
#pragma once
#include <cstdint>
#include <vector>

#include "film/path_automaton.h"

namespace kinora::film {

class PathTails {
 public:
  // Numbers of each table at most: 16 MB together with the other.
  static constexpr size_t kMostNumbers = 1 << 21;

  PathTails() = default;
  explicit PathTails(const PathAutomaton& automaton);

  uint32_t count() const { return count_; }
  // After an event at one more vertex away from the light: [tail * events + event]. Tail 0: no event yet.
  const std::vector<uint32_t>& next() const { return next_; }
  // [tail * states + state]: a state that takes what the automaton's would at every end of a path.
  const std::vector<uint32_t>& end() const { return end_; }
  // Some tails did not fit: events that would lead to them are left out.
  bool isTooLarge() const { return isTooLarge_; }

 private:
  std::vector<uint32_t> next_, end_;
  uint32_t count_ = 0;
  bool isTooLarge_ = false;
};

}  // namespace kinora::film
