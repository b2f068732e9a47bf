#pragma once

namespace sinew::plant {

/// Lets MuJoCo find the contacts of boxes, capsules, spheres and cylinders with the pitch's uneven ground by functions
/// of ours: its own cut the ground into prisms and take each against each shape, which for eight robots costs more than
/// all the rest of a step, and gives a contact for each prism. Height fields of other worlds are left to MuJoCo's.
/// Ours: corners and rims against the surface (bilinear between the field's points, which slope by at most a tenth or
/// two), and the field's points against the faces of boxes. Idempotent.
/// Thread:  before any step of a pitch; MuJoCo's table of functions is global.
void use_own_ground_contacts();

}  // namespace sinew::plant
