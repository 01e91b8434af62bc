// What C++ has, as objects of Python.

#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <cstdint>
#include <vector>

#include "bindings.h"
#include "lab/frames.h"
#include "scenarios/episode.h"
#include "scenarios/scene.h"
#include "scenarios/view.h"

namespace cxlab::python {

using namespace nb::literals;

void raise(const Error& error) {
  const nb::object made = nb::module_::import_("cxlab.errors")
                              .attr("error_of")(static_cast<int>(error.kind), text(error.message), text(error.file),
                                                error.line, text(error.code));
  PyErr_SetObject(made.type().ptr(), made.ptr());
  throw nb::python_error();
}

nb::str text(std::string_view bytes) {
  PyObject* made = PyUnicode_DecodeUTF8(bytes.data(), static_cast<Py_ssize_t>(bytes.size()), "replace");
  if (!made) throw nb::python_error();
  return nb::steal<nb::str>(made);
}

nb::object from_json(std::string_view json) { return nb::module_::import_("json").attr("loads")(text(json)); }

SharedObject share(nb::object object) {
  return {new nb::object(std::move(object)), [](nb::object* kept) {
            const nb::gil_scoped_acquire lock;
            delete kept;
          }};
}

nb::object to_python(const Value& value) {
  switch (value.type()) {
    case ValueType::kVoid: return nb::none();
    case ValueType::kInteger: return nb::int_(value.as_integer());
    case ValueType::kFloat: return nb::float_(value.as_number());
    case ValueType::kSymbol:
    case ValueType::kString: return text(value.text());
    case ValueType::kMultifield: {
      nb::list list;
      for (const Value& item : value.items()) list.append(to_python(item));
      return list;
    }
    default: return text(value.print());
  }
}

namespace {

nb::object element(const bus::MessageView& message, const bus::Field& field, std::size_t index) {
  if (field.is_message()) return to_python(message.nested(field, index));
  if (field.is_text()) return text(message.text(field, index));
  if (field.is_real()) return nb::float_(message.real(field, index));
  const std::int64_t number = message.integer(field, index);
  if (field.type == bus::FieldType::kBool) return nb::bool_(number != 0);
  if (field.type == bus::FieldType::kUint64) return nb::int_(static_cast<std::uint64_t>(number));
  return nb::int_(number);
}

/// An array of NumPy of that shape that owns its values.
template <class T>
nb::object array_of(std::vector<T> values, std::initializer_list<std::size_t> shape) {
  auto owned = std::make_unique<std::vector<T>>(std::move(values));
  T* data = owned->data();
  const nb::capsule owner(owned.release(), [](void* kept) noexcept { delete static_cast<std::vector<T>*>(kept); });
  return nb::cast(nb::ndarray<nb::numpy, T>(data, shape, owner));
}

}  // namespace

nb::object to_python(const bus::MessageView& message) {
  nb::dict fields;
  if (!message) return fields;
  for (const bus::Field& field : message.type().fields()) {
    nb::object value;
    if (field.array == bus::ArrayKind::kSingle) {
      value = element(message, field, 0);
    } else {
      nb::list list;
      for (std::size_t i = 0; i < message.size(field); ++i) list.append(element(message, field, i));
      value = std::move(list);
    }
    fields[text(field.name)] = value;
  }
  return fields;
}

nb::dict to_python(const Scene& scene) {
  const std::size_t count = scene.entities.size();
  std::vector<std::int64_t> ids, carriers;
  std::vector<double> x, y, z, yaw;
  nb::list kinds, names, states, places;
  for (const Entity& entity : scene.entities) {
    const sim::Pose3 pose = scene.in_world(entity);
    ids.push_back(entity.id);
    carriers.push_back(entity.carried_by.value_or(0));
    x.push_back(pose.position.x());
    y.push_back(pose.position.y());
    z.push_back(pose.position.z());
    yaw.push_back(pose.yaw());
    kinds.append(text(entity.kind));
    names.append(text(entity.name));
    states.append(text(entity.state));
    places.append(text(entity.place));
  }
  const nb::object texts = nb::module_::import_("numpy").attr("array");
  const auto column = [&texts](const nb::list& cells) { return texts(cells, "dtype"_a = "U"); };
  nb::dict table;
  table["id"] = array_of(std::move(ids), {count});
  table["kind"] = column(kinds);
  table["name"] = column(names);
  table["state"] = column(states);
  table["x"] = array_of(std::move(x), {count});
  table["y"] = array_of(std::move(y), {count});
  table["z"] = array_of(std::move(z), {count});
  table["yaw"] = array_of(std::move(yaw), {count});
  table["carried_by"] = array_of(std::move(carriers), {count});
  table["place"] = column(places);
  return table;
}

nb::object Renderer::draw(Episode& episode, int width, int height, const std::string& camera, bool caption) {
  Expected<const sim::Picture*> drawn = usage_error("");
  {
    const nb::gil_scoped_release others_may_run;
    std::unique_ptr<lab::Frames>& frames = frames_[{width, height, caption}];
    if (!frames) {
      const ViewMaker make = [&episode](int w, int h) { return view_of(episode.stage(), w, h); };
      auto made = lab::Frames::create(make, {.width = width, .height = height, .caption = caption});
      if (made)
        frames = *std::move(made);
      else
        drawn = made.error();
    }
    if (frames) {
      const std::vector<std::string> cameras{camera.empty() ? frames->cameras().front() : camera};
      drawn = frames->draw(cameras, std::max(episode.now(), SimTime::zero()));
    }
  }
  const sim::Picture& picture = *value_or_raise(std::move(drawn));
  return array_of(picture.rgb,
                  {static_cast<std::size_t>(picture.height), static_cast<std::size_t>(picture.width), std::size_t{3}});
}

}  // namespace cxlab::python
