#include "lab/export/picture_channel.h"

#include <algorithm>

#include "cx/base/file.h"

namespace cxlab::lab {

Expected<PictureChannel> PictureChannel::create(RosBag& bag, const Run& run, const PictureChoice& choice) {
  if (run.finished && !run.physics_hash)
    return input_error(
        "--pictures: the run has no physics to draw; cxlab run --tier physics plays it with bodies. The 3D panel of "
        "Foxglove shows it without pictures",
        run.folder.string());
  auto physics = PhysicsOfRun::load(run);
  if (!physics) return physics.error();
  PictureChannel out(bag, *std::move(physics));
  auto view = out.physics_.view(choice.width, choice.height);
  if (!view) return view.error();
  out.view_ = *std::move(view);
  auto scratch = ScratchFolder::create();
  if (!scratch) return scratch.error();
  out.scratch_ = *std::move(scratch);
  out.every_ = choice.every;
  out.camera_ = choice.camera.empty() ? out.view_->cameras().front() : choice.camera;
  return out;
}

Status PictureChannel::see(const Scene& scene) {
  if (scene.t < next_) return {};
  next_ = scene.t + every_;
  if (Status s = physics_.advance_to(scene.t); !s) return s;
  const auto picture = view_->draw(camera_);
  if (!picture) return picture.error();
  const std::filesystem::path file = scratch_->path() / "picture.png";
  if (Status s = sim::write_png(**picture, file); !s) return s;
  const auto png = read_file(file);
  if (!png) return png.error();
  const bus::MessageType& type = bag_.own("sensor_msgs/msg/CompressedImage");
  bag_.put("/cxlab/camera/" + topic_part(camera_), scene.t,
           {type.name(), [&] { return bus::ros2msg_schema(type); },
            [&](bus::CdrWriter& out) {
              write_stamp(out, scene.t);
              out.text(camera_).text("png").size(png->size()).bytes(*png);
            }});
  return {};
}

}  // namespace cxlab::lab
