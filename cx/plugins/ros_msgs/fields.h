#pragma once
// Fields of messages as values of CLIPS, and back.

#include <string_view>

#include "cx/engine/function.h"
#include "cx/plugins/ros_msgs/message_store.h"

namespace cxlab::cx {

/// Gives the field as the result of the call: booleans are TRUE and FALSE, whole numbers INTEGER, others FLOAT, a char
/// is a STRING of one character, a nested message a handle into its parent, an array a multifield.
/// An unknown message or field ends the call with an error.
void give_field(Call& call, MessageStore& store, Handle message, std::string_view field);

/// Sets the field from a value. INTEGER and FLOAT are converted where that is exact; a value that does not fit is an
/// error. Messages are copied in. Arrays take a multifield, those of fixed size one of exactly that size.
void set_field(Call& call, MessageStore& store, Handle message, std::string_view field, const ValueRef& value);

}  // namespace cxlab::cx
