#include "film/path_tails.h"

#include <algorithm>
#include <map>

namespace kinora::film {

PathTails::PathTails(const PathAutomaton& automaton) {
  const uint32_t states = automaton.states(), events = automaton.events(), ends = automaton.ends();
  using Function = std::vector<uint32_t>;
  Function nothing(states);
  std::map<std::vector<std::vector<uint16_t>>, uint32_t> alike;
  // no path is joined to another before its first event: what becomes of the start tells no functions apart
  for (uint32_t s = automaton.start() + 1; s < states; ++s) {
    std::vector<std::vector<uint16_t>> taken;
    for (uint32_t e = 0; e < ends; ++e) taken.push_back(automaton.accepted(s, e));
    nothing[s] = alike.try_emplace(std::move(taken), s).first->second;
  }
  const size_t most = std::max<size_t>(1, kMostNumbers / std::max(states, events));
  std::map<Function, uint32_t> known{{nothing, 0}};
  std::vector<const Function*> all{&known.begin()->first};
  for (uint32_t t = 0; t < all.size(); ++t) {
    end_.insert(end_.end(), all[t]->begin(), all[t]->end());
    for (uint32_t e = 0; e < events; ++e) {
      Function after(states);
      for (uint32_t s = automaton.start() + 1; s < states; ++s) after[s] = (*all[t])[automaton.next(s, e)];
      auto it = known.find(after);
      if (it == known.end() && all.size() < most) {
        it = known.emplace(std::move(after), uint32_t(all.size())).first;
        all.push_back(&it->first);
      }
      isTooLarge_ |= it == known.end();
      next_.push_back(it == known.end() ? t : it->second);
    }
  }
  count_ = uint32_t(all.size());
}

}  // namespace kinora::film
