// Digests of single things of a description, for whoever keeps what was made of them over an edit: equal digests, the
// same thing again. They walk the lists of scene/fields.h, so that no field is forgotten; ids of other things count
// as they are. Asked by render/ when a world is made anew. A whole scene's digest is scene/identity.h's.
#pragma once
#include <map>
#include <string>
#include <unordered_map>
#include <vector>

#include "base/digest.h"
#include "scene/scene.h"

namespace kinora::scene {

// What decides pixels; places in files and the book-keeping of edits do not count.
Digest digestOf(const Camera& camera);
Digest digestOf(const Network& network);
Digest digestOf(const NodePtr& node);
Digest digestOf(const ParameterList& list);
Digest digestOf(const Transform& transform);
Digest digestOf(const std::map<std::string, Transform>& spaces);
// All but the attributes: they are shared, and mostly they are what did not change.
Digest ownDigestOf(const Primitive& primitive);
Digest ownDigestOf(const Light& light);
// Of a scene all that is neither a camera nor a thing in the world, with what is noted for people: names of files
// are.
Digest frameDigestOf(const Scene& scene);

// Digests of shared things, remembered with them. What is shared is const: an edit puts another one in its place, and
// while this holds the old one nothing else can have its address.
class NetworkDigests {
 public:
  Digest of(const NetworkPtr& network);
  void forgetOthers();  // those that were not asked for since the last time

 private:
  struct Known {
    NetworkPtr network;
    Digest digest;
    bool isAsked = true;
  };
  std::unordered_map<const Network*, Known> known_;
};

}  // namespace kinora::scene
