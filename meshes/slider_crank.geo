// The slider-crank of demos/slider_crank.toml at drive angle 0: crank OA, rod AB, its guide 10 mm above O. Lengths in mm.
//
// Physical curves are the links, physical points the joints: "ground O" is a pin in the ground, "joint A" a pin through all
// links that have the end of a line there. B slides along the guide: that joint is in slider_crank.toml, and here B is
// only a named point, "point B".

crank = 60; rod = 300; offset = 10;
b_x = crank + Sqrt(rod^2 - offset^2);

Point(1) = {0, 0, 0};
Point(2) = {crank, 0, 0};
Point(3) = {b_x, offset, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Transfinite Curve {1} = 4;
Transfinite Curve {2} = 5;

// the guide: a line in no physical group is a construction line
Point(4) = {b_x - 2 * crank, offset, 0};
Line(3) = {4, 3};

Physical Point("ground O") = {1};
Physical Point("joint A") = {2};
Physical Point("point B") = {3};
Physical Curve("crank") = {1};
Physical Curve("rod") = {2};
