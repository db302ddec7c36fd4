// The four-bar of Kaminski 1989, chapter 7, at drive angle 0: crank OA, coupler AB, follower CB. Lengths in metres.
//
// Physical curves are the links ("link" or "link.member"), physical points the joints: "joint A" is a pin through all
// links that have the end of a line there, "ground O" one in the ground as well, "point D" no joint but a name.
// Sections, materials, masses and the drive are in four_bar.toml; `fenics_mech/scene/drawing` documents the convention.

inch = 0.0254;
crank = 4.25 * inch; coupler = 11 * inch; follower = 10.65 * inch; base = 10 * inch;

// B by the cosine rule on the triangle ABC
diagonal = base - crank;
along = (coupler^2 + diagonal^2 - follower^2) / (2 * diagonal);
across = Sqrt(coupler^2 - along^2);

Point(1) = {0, 0, 0};
Point(2) = {crank, 0, 0};
Point(3) = {crank + along, across, 0};
Point(4) = {base, 0, 0};

Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {4, 3};
Transfinite Curve {1, 2, 3} = 4; // nodes: three elements a member

Physical Point("ground O") = {1};
Physical Point("joint A") = {2};
Physical Point("joint B") = {3};
Physical Point("ground C") = {4};
Physical Curve("crank") = {1};
Physical Curve("coupler") = {2};
Physical Curve("follower") = {3};
