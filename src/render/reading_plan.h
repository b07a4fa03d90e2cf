// Which procedurals are held next, where not all that rays ask for fit in memory together. Groups of rays that met what
// is not there wait, each with all that it is known to need; a plan lets some of them go on, what they need being held
// at the same time, and drops what the budget has no room for beside it. A pure function: what a plan decides is time,
// never a pixel. Asked by Renderer between the tries of groups (Frame::forEachItem).
#pragma once
#include <cstdint>
#include <limits>
#include <vector>

namespace kinora::render {

struct WaitingGroup {
  std::vector<uint32_t> met;    // by number in the world's UnreadBounds, at the last try
  std::vector<uint32_t> needs;  // procedurals, by Procedurals' numbers: all that it has met so far; rising
  bool isWhole = true;          // false: it may be tried in two halves
  enum class Turn : uint8_t { Now, Later, Halves };
  Turn turn = Turn::Now;
};

// A procedural, as a plan sees it.
struct HeldProcedural {
  static constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();
  uint64_t bytes = 0;  // that it takes, or is expected to take
  bool isHeld = false;
  uint32_t inside = kNone;  // the procedural that it is said by: held while this one is
  uint64_t lastNeeded = 0;  // the plan that needed it last, counted by the caller
};

struct ReadingPlan {
  std::vector<uint32_t> read, drop;  // rising; those in `drop` come before what they are inside of
  uint64_t needed = 0;               // bytes of all that is needed now
  uint32_t groups = 0;               // that go on
};

// Sets the groups' turns. Their needs must hold what these are inside of as well. At least one group goes on or is
// halved. What is needed now is more than the budget only where a whole group needs that.
ReadingPlan planReading(std::vector<WaitingGroup*>& groups, const std::vector<HeldProcedural>& procedurals,
                        uint64_t budget);

}  // namespace kinora::render
