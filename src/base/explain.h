// The long form of each message code, for `kinora explain CODE`. Rooms that report messages publish a table; app/
// adds the tables of the rooms it links, by name, in one place. It registers nothing by itself and prints nothing.
#pragma once
#include <span>
#include <string_view>
#include <vector>

namespace kinora {

struct Explanation {
  std::string_view code;  // "RIB-SYNTAX"; one that ends in '-' explains all that begin with it ("RIB-KEPT-")
  std::string_view text;  // a paragraph or more: what it means, what was done, what to try
};

class Explanations {
 public:
  void add(std::span<const Explanation> table);          // the table must outlive this object
  const Explanation* find(std::string_view code) const;  // without case; null: unknown
  std::vector<std::string_view> codes() const;           // all, sorted

 private:
  std::vector<std::span<const Explanation>> tables_;
};

}  // namespace kinora
