#include "base/file_name.h"

#include <cassert>
#include <deque>
#include <mutex>
#include <unordered_map>

namespace kinora {

namespace {
struct Names {
  std::mutex lock;
  std::deque<std::string> byId;  // its strings do not move
  std::unordered_map<std::string_view, uint32_t> ids;
};
// Never destroyed: messages may still be said while other statics are.
Names& names() {
  static Names& kept = *new Names;
  return kept;
}
}  // namespace

FileName::FileName(std::string_view name) {
  Names& n = names();
  const std::lock_guard hold(n.lock);
  if (const auto at = n.ids.find(name); at != n.ids.end()) {
    id_ = at->second;
    return;
  }
  const std::string& kept = n.byId.emplace_back(name);
  id_ = uint32_t(n.byId.size());
  n.ids.emplace(kept, id_);
}

const std::string& FileName::operator*() const {
  assert(id_ != 0);
  Names& n = names();
  const std::lock_guard hold(n.lock);
  return n.byId[id_ - 1];
}

}  // namespace kinora
