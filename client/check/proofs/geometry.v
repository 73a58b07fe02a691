(* geometry: what axes, points, times and directions prove, over the reals; with what the lemmas of Gappa and rounding.v
   say of rounding, "accepted implies true". coqc geometry.v *)
Require Import Reals Lra Psatz List.
Import ListNotations.
Open Scope R_scope.
Set Default Timeout 600.

(* ---- vectors ---- *)

Record vec := V { x : R; y : R; z : R }.
Definition dot a b := x a * x b + y a * y b + z a * z b.
Definition add a b := V (x a + x b) (y a + y b) (z a + z b).
Definition sub a b := V (x a - x b) (y a - y b) (z a - z b).
Definition mul s a := V (s * x a) (s * y a) (s * z a).
Definition cross a b := V (y a * z b - z a * y b) (z a * x b - x a * z b) (x a * y b - y a * x b).
Definition norm a := sqrt (dot a a).
Definition O := V 0 0 0.

Lemma dot_self : forall a, 0 <= dot a a.
Proof. intros [a b c]; unfold dot; simpl; nra. Qed.
Lemma norm_pos : forall a, 0 <= norm a.
Proof. intro; apply sqrt_pos. Qed.
Lemma norm_sq : forall a, norm a * norm a = dot a a.
Proof. intro; apply sqrt_sqrt, dot_self. Qed.
Lemma dot_comm : forall a b, dot a b = dot b a.
Proof. intros; unfold dot; ring. Qed.
Lemma dot_sub : forall n a b, dot n (sub a b) = dot n a - dot n b.
Proof. intros; unfold dot, sub; simpl; ring. Qed.
Lemma dot_add : forall n a b, dot n (add a b) = dot n a + dot n b.
Proof. intros; unfold dot, add; simpl; ring. Qed.
Lemma dot_mul : forall n s a, dot n (mul s a) = s * dot n a.
Proof. intros; unfold dot, mul; simpl; ring. Qed.
Lemma dot_mul_l : forall n s a, dot (mul s n) a = s * dot n a.
Proof. intros; unfold dot, mul; simpl; ring. Qed.
Lemma norm_mul : forall s a, norm (mul s a) = Rabs s * norm a.
Proof.
  intros; unfold norm. rewrite dot_mul, dot_mul_l, <- Rmult_assoc, sqrt_mult_alt by nra.
  f_equal. apply sqrt_Rsqr_abs.
Qed.

(* For bounds of norms: compare squares. *)
Lemma norm_le : forall a r, 0 <= r -> dot a a <= r * r -> norm a <= r.
Proof. intros a r Hr H; unfold norm; rewrite <- (sqrt_square r Hr); now apply sqrt_le_1_alt. Qed.
Lemma le_of_sq : forall a b, 0 <= b -> a * a <= b * b -> a <= b.
Proof. intros; nra. Qed.

Lemma cauchy_schwarz : forall a b, dot a b <= norm a * norm b.
Proof.
  intros a b. apply le_of_sq.
  - apply Rmult_le_pos; apply norm_pos.
  - replace (norm a * norm b * (norm a * norm b)) with (dot a a * dot b b)
      by (rewrite <- (norm_sq a), <- (norm_sq b); ring).
    destruct a as [a1 a2 a3], b as [b1 b2 b3]; unfold dot; simpl.
    pose proof (Rle_0_sqr (a1 * b2 - a2 * b1)); pose proof (Rle_0_sqr (a1 * b3 - a3 * b1));
    pose proof (Rle_0_sqr (a2 * b3 - a3 * b2)); unfold Rsqr in *; nra.
Qed.
Lemma triangle : forall a b, norm (add a b) <= norm a + norm b.
Proof.
  intros a b. apply norm_le.
  - pose proof (norm_pos a); pose proof (norm_pos b); lra.
  - pose proof (cauchy_schwarz a b). pose proof (norm_sq a). pose proof (norm_sq b).
    replace (dot (add a b) (add a b)) with (dot a a + 2 * dot a b + dot b b) by (unfold dot, add; simpl; ring).
    nra.
Qed.
Lemma norm_sym : forall a b, norm (sub a b) = norm (sub b a).
Proof. intros; unfold norm; f_equal; unfold dot, sub; simpl; ring. Qed.
Lemma triangle_sub : forall a b c, norm (sub a c) <= norm (sub a b) + norm (sub b c).
Proof.
  intros. replace (sub a c) with (add (sub a b) (sub b c)) by (unfold add, sub; simpl; f_equal; ring). apply triangle.
Qed.
Lemma norm_lipschitz : forall a b, norm a <= norm b + norm (sub a b).
Proof. intros. replace a with (add b (sub a b)) at 1 by (destruct a; unfold add, sub; simpl; f_equal; ring). apply triangle. Qed.
(* The error of a vector whose coordinates are each off by e. *)
Lemma norm_of_coordinates : forall a e, 0 <= e -> Rabs (x a) <= e -> Rabs (y a) <= e -> Rabs (z a) <= e -> norm a <= sqrt 3 * e.
Proof.
  intros [a b c] e He Ha Hb Hc; simpl in *.
  assert (S3 : sqrt 3 * sqrt 3 = 3) by (apply sqrt_sqrt; lra). pose proof (sqrt_pos 3).
  apply norm_le; [nra|]. unfold dot; simpl.
  assert (a * a <= e * e) by (revert Ha; unfold Rabs; destruct (Rcase_abs a); nra).
  assert (b * b <= e * e) by (revert Hb; unfold Rabs; destruct (Rcase_abs b); nra).
  assert (c * c <= e * e) by (revert Hc; unfold Rabs; destruct (Rcase_abs c); nra).
  nra.
Qed.

(* ---- the signed distance, and what proves its bounds ---- *)

Definition set := vec -> Prop.
(* s is not above sep(n) for some unit n *)
Definition separated (A B : set) s := exists n, norm n = 1 /\ forall a b, A a -> B b -> s <= dot n (sub b a).
Definition signed_distance (A B : set) D := is_lub (separated A B) D.

Theorem axis_proves_lo : forall A B D n lo, signed_distance A B D -> 0 < norm n ->
  (forall a b, A a -> B b -> lo * norm n <= dot n (sub b a)) -> lo <= D.
Proof.
  intros A B D n lo [Hub _] Hn H. apply Hub. exists (mul (/ norm n) n). split.
  - rewrite norm_mul, Rabs_pos_eq; [field; lra | left; now apply Rinv_0_lt_compat].
  - intros a b Ha Hb. rewrite dot_mul_l. specialize (H a b Ha Hb).
    apply (Rmult_le_reg_l (norm n)); [assumption|]. replace (norm n * (/ norm n * dot n (sub b a))) with (dot n (sub b a)) by (field; lra). lra.
Qed.

(* The same without the signed distance: no two points are nearer; or, of a negative lo, B moved by so much is parted from A. *)
Theorem axis_keeps_apart : forall (A B : set) n lo, norm n = 1 -> (forall a b, A a -> B b -> lo <= dot n (sub b a)) ->
  (forall a b, A a -> B b -> lo <= norm (sub b a)) /\ (forall a b, A a -> B b -> 0 <= dot n (sub (add b (mul (- lo) n)) a)).
Proof.
  intros A B n lo Hn H. split; intros a b Ha Hb; specialize (H a b Ha Hb).
  - pose proof (cauchy_schwarz n (sub b a)); rewrite Hn in *; lra.
  - assert (N : dot n n = 1) by (rewrite <- norm_sq, Hn; ring).
    rewrite dot_sub, dot_add, dot_mul, N. rewrite dot_sub in H; lra.
Qed.

Theorem points_prove_hi : forall (A B : set) D a b, signed_distance A B D -> A a -> B b -> D <= norm (sub b a).
Proof.
  intros A B D a b [_ Hl] Ha Hb. apply Hl. intros s [n [Hn H]]. specialize (H a b Ha Hb).
  pose proof (cauchy_schwarz n (sub b a)); rewrite Hn in *; lra.
Qed.

(* Points that are near, and shapes that stand for something finer inside of them. *)
Theorem near_points_prove_hi : forall (A B SA SB : set) D pa pb ea eb da db,
  signed_distance SA SB D ->
  (exists a, A a /\ norm (sub pa a) <= ea) -> (exists b, B b /\ norm (sub pb b) <= eb) ->
  (forall a, A a -> exists s, SA s /\ norm (sub a s) <= da) -> (forall b, B b -> exists s, SB s /\ norm (sub b s) <= db) ->
  D <= norm (sub pb pa) + ea + eb + da + db.
Proof.
  intros A B SA SB D pa pb ea eb da db HD [a [Ha Ea]] [b [Hb Eb]] HA HB.
  destruct (HA a Ha) as [s [Hs Es]], (HB b Hb) as [t [Ht Et]].
  pose proof (points_prove_hi _ _ _ _ _ HD Hs Ht).
  pose proof (triangle_sub t b s). pose proof (triangle_sub b pb s). pose proof (triangle_sub pb pa s). pose proof (triangle_sub pa a s).
  pose proof (norm_sym t b). pose proof (norm_sym b pb). lra.
Qed.
Theorem lo_holds_inside : forall (A B SA SB : set) D D', (forall a, SA a -> A a) -> (forall b, SB b -> B b) ->
  signed_distance A B D -> signed_distance SA SB D' -> D <= D'.
Proof.
  intros A B SA SB D D' HA HB [_ Hl] [Hu _]. apply Hl. intros s [n [Hn H]]. apply Hu. exists n. split; auto.
Qed.

(* ---- cores: what they reach along d, a point of them near any q, and that they are convex ---- *)

Definition reaches (S : set) d h := forall p, S p -> dot d p <= h.
Definition near (S : set) q e := exists p, S p /\ norm (sub q p) <= e.
Definition convex (S : set) := forall p q t, 0 <= t <= 1 -> S p -> S q -> S (add (mul (1 - t) p) (mul t q)).

Definition flat a b := V a b 0.
Definition across v := norm (flat (x v) (y v)).
Lemma flat_le : forall a b c d, a * c + b * d <= norm (flat a b) * norm (flat c d).
Proof. intros. pose proof (cauchy_schwarz (flat a b) (flat c d)). unfold dot in H; simpl in H. lra. Qed.

Definition sphere : set := fun p => p = O.
Definition capsule h : set := fun p => x p = 0 /\ y p = 0 /\ Rabs (z p) <= h.
Definition box h1 h2 h3 : set := fun p => Rabs (x p) <= h1 /\ Rabs (y p) <= h2 /\ Rabs (z p) <= h3.
Definition cylinder r h : set := fun p => across p <= r /\ Rabs (z p) <= h.
Definition cone r h : set := fun p => exists s, 0 <= s <= 1 /\ across p <= s * r /\ z p = h * (1 - 2 * s).
Definition stretch h u := V (x h * x u) (y h * y u) (z h * z u).
Definition ellipsoid h : set := fun p => exists u, norm u <= 1 /\ p = stretch h u.
Definition halfspace : set := fun p => z p <= 0.
Inductive hull (ps : list vec) : set :=
  | corner : forall p, In p ps -> hull ps p
  | between : forall p q t, 0 <= t <= 1 -> hull ps p -> hull ps q -> hull ps (add (mul (1 - t) p) (mul t q)).

Lemma abs_mul_le : forall a b h, Rabs b <= h -> a * b <= h * Rabs a.
Proof. intros a b h; unfold Rabs; destruct (Rcase_abs a), (Rcase_abs b); nra. Qed.

Theorem sphere_reaches : forall d, reaches sphere d 0.
Proof. intros d p ->; unfold dot, O; simpl; lra. Qed.
Theorem capsule_reaches : forall d h, reaches (capsule h) d (h * Rabs (z d)).
Proof. intros d h p (Hx & Hy & Hz); unfold dot; rewrite Hx, Hy. pose proof (abs_mul_le (z d) _ _ Hz); lra. Qed.
Theorem box_reaches : forall d a b c, reaches (box a b c) d (a * Rabs (x d) + b * Rabs (y d) + c * Rabs (z d)).
Proof.
  intros d a b c p (Hx & Hy & Hz); unfold dot.
  pose proof (abs_mul_le (x d) _ _ Hx); pose proof (abs_mul_le (y d) _ _ Hy); pose proof (abs_mul_le (z d) _ _ Hz); lra.
Qed.
Lemma across_le : forall d p r, across p <= r -> x d * x p + y d * y p <= r * across d.
Proof. intros d p r H. pose proof (flat_le (x d) (y d) (x p) (y p)). unfold across in *. pose proof (norm_pos (flat (x d) (y d))). nra. Qed.
Theorem cylinder_reaches : forall d r h, reaches (cylinder r h) d (r * across d + h * Rabs (z d)).
Proof. intros d r h p (Hr & Hz); unfold dot. pose proof (across_le d p r Hr); pose proof (abs_mul_le (z d) _ _ Hz); lra. Qed.
Theorem cone_reaches : forall d r h, reaches (cone r h) d (Rmax (h * z d) (r * across d - h * z d)).
Proof.
  intros d r h p (s & [H0 H1] & Hr & Hz); unfold dot; rewrite Hz. pose proof (across_le d p (s * r) Hr).
  pose proof (Rmax_l (h * z d) (r * across d - h * z d)); pose proof (Rmax_r (h * z d) (r * across d - h * z d)).
  set (M := Rmax _ _) in *. nra.
Qed.
Theorem ellipsoid_reaches : forall d h, reaches (ellipsoid h) d (norm (stretch h d)).
Proof.
  intros d h p (u & Hu & ->). pose proof (cauchy_schwarz (stretch h d) u). pose proof (norm_pos (stretch h d)).
  replace (dot d (stretch h u)) with (dot (stretch h d) u) by (unfold dot, stretch; simpl; ring). nra.
Qed.
Theorem halfspace_reaches : reaches halfspace (V 0 0 1) 0.
Proof. intros p H; unfold halfspace, dot in *; simpl; lra. Qed.
Theorem hull_reaches : forall ps d h, (forall p, In p ps -> dot d p <= h) -> reaches (hull ps) d h.
Proof. intros ps d h H p Hp. induction Hp; [auto | rewrite dot_add, !dot_mul; nra]. Qed.
(* A shape rounded by r, a union, and a frame that is turned (R keeps products) and moved. *)
Definition rounded (S : set) r : set := fun p => exists c, S c /\ norm (sub p c) <= r.
Theorem rounded_reaches : forall S d h r, reaches S d h -> reaches (rounded S r) d (h + r * norm d).
Proof.
  intros S d h r H p (c & Hc & Hr). specialize (H c Hc). pose proof (cauchy_schwarz d (sub p c)). rewrite dot_sub in *.
  pose proof (norm_pos d). nra.
Qed.
Theorem union_reaches : forall (F : nat -> set) d h, (forall i, reaches (F i) d h) -> reaches (fun p => exists i, F i p) d h.
Proof. intros F d h H p (i & Hi). exact (H i p Hi). Qed.

(* ---- rotations by a quaternion that need not be unit ---- *)

Definition square w u := w * w + dot u u.
Definition turned w u v := add v (mul (2 / square w u) (add (mul w (cross u v)) (cross u (cross u v)))).
Lemma square_vec : forall w u, square w u = w * w + x u * x u + y u * y u + z u * z u.
Proof. intros; unfold square, dot; ring. Qed.
Theorem turned_keeps : forall w u v v', square w u <> 0 -> dot (turned w u v) (turned w u v') = dot v v'.
Proof.
  intros w [a b c] [d e f] [d' e' f'] H. unfold turned, dot, add, mul, cross; simpl. rewrite square_vec in *; simpl in *. field; repeat split; intro; apply H; lra.
Qed.
Theorem turned_back : forall w u v v', square w u <> 0 -> dot v (turned w u v') = dot (turned (- w) u v) v'.
Proof.
  intros w [a b c] [d e f] [d' e' f'] H. unfold turned, dot, add, mul, cross; simpl. rewrite !square_vec in *; simpl in *. field; repeat split; intro; apply H; lra.
Qed.
Theorem turned_norm : forall w u v, square w u <> 0 -> norm (turned w u v) = norm v.
Proof. intros; unfold norm; rewrite turned_keeps; auto. Qed.
Theorem turned_linear : forall w u v v', sub (turned w u v) (turned w u v') = turned w u (sub v v').
Proof. intros; unfold turned, sub, add, mul, cross; simpl; f_equal; ring. Qed.
(* What lemma turned of Gappa takes for granted of exact numbers. *)
Theorem cross_le : forall u v, norm (cross u v) <= norm u * norm v.
Proof.
  intros. apply norm_le; [apply Rmult_le_pos; apply norm_pos|].
  replace (norm u * norm v * (norm u * norm v)) with (dot u u * dot v v) by (rewrite <- (norm_sq u), <- (norm_sq v); ring).
  replace (dot (cross u v) (cross u v)) with (dot u u * dot v v - dot u v * dot u v) by (unfold dot, cross; simpl; ring).
  pose proof (Rle_0_sqr (dot u v)); unfold Rsqr in *; lra.
Qed.
Theorem turn_moves : forall w u v, square w u <> 0 -> norm (sub (turned w u v) v) <= 2 * norm v.
Proof.
  intros. pose proof (triangle_sub (turned w u v) O v). rewrite norm_sym with (a := O) in H0.
  replace (sub (turned w u v) O) with (turned w u v) in H0 by (destruct (turned w u v); unfold sub, O; simpl; f_equal; ring).
  replace (sub v O) with v in H0 by (destruct v; unfold sub, O; simpl; f_equal; ring).
  rewrite turned_norm in H0 by assumption. lra.
Qed.

Definition placed (S : set) p w u : set := fun v => exists c, S c /\ v = add p (turned w u c).
Theorem placed_reaches : forall S p w u n h, square w u <> 0 ->
  reaches S (turned (- w) u n) h -> reaches (placed S p w u) n (dot n p + h).
Proof. intros S p w u n h Hq H v (c & Hc & ->). rewrite dot_add, turned_back by assumption. specialize (H c Hc). lra. Qed.
Lemma dot_ext : forall a b, (forall n, dot n a = dot n b) -> a = b.
Proof.
  intros [a b c] [d e f] H. pose proof (H (V 1 0 0)). pose proof (H (V 0 1 0)). pose proof (H (V 0 0 1)).
  unfold dot in *; simpl in *. f_equal; lra.
Qed.
Lemma turned_inverse : forall w u v, square w u <> 0 -> turned w u (turned (- w) u v) = v.
Proof.
  intros w u v H. assert (H' : square (- w) u <> 0) by (unfold square in *; replace (- w * - w) with (w * w) by ring; exact H).
  apply dot_ext. intro n. rewrite turned_back, turned_keeps by assumption. reflexivity.
Qed.
Theorem placed_near : forall S p w u q e, square w u <> 0 ->
  near S (turned (- w) u (sub q p)) e -> near (placed S p w u) q e.
Proof.
  intros S p w u q e Hq (c & Hc & He). exists (add p (turned w u c)). split; [now exists c|].
  replace (sub q (add p (turned w u c))) with (turned w u (sub (turned (- w) u (sub q p)) c)).
  - now rewrite turned_norm.
  - rewrite <- turned_linear, turned_inverse by assumption. unfold sub, add; simpl; f_equal; ring.
Qed.
Theorem rounded_near : forall S q e r, 0 <= r -> near S q e -> near (rounded S r) q (Rmax (e - r) 0).
Proof.
  intros S q e r Hr (c & Hc & He). destruct (Rle_dec (norm (sub q c)) r) as [Hin | Hout].
  - exists q. split; [now exists c|]. replace (sub q q) with O by (unfold sub, O; f_equal; ring).
    replace (norm O) with 0; [apply Rmax_r|]. unfold norm, O, dot; simpl. replace (0*0+0*0+0*0) with 0 by ring. now rewrite sqrt_0.
  - set (d := norm (sub q c)) in *. assert (0 < d) by lra. pose proof (Rmax_l (e - r) 0).
    exists (add c (mul (r / d) (sub q c))). split.
    + exists c. split; auto. replace (sub (add c (mul (r / d) (sub q c))) c) with (mul (r / d) (sub q c)) by (unfold sub, add, mul; simpl; f_equal; ring).
      rewrite norm_mul, Rabs_pos_eq. fold d. right; field; lra. apply Rmult_le_pos; [lra | left; now apply Rinv_0_lt_compat].
    + replace (sub q (add c (mul (r / d) (sub q c)))) with (mul (1 - r / d) (sub q c)) by (unfold sub, add, mul; simpl; f_equal; ring).
      rewrite norm_mul, Rabs_pos_eq.
      * fold d. replace ((1 - r / d) * d) with (d - r) by (field; lra). lra.
      * apply Rmult_le_reg_l with d; auto. replace (d * (1 - r / d)) with (d - r) by (field; lra). lra.
Qed.

(* ---- points of the cores that are near any q: what core_distance makes, whatever was proposed ---- *)

Definition beyond a h := Rmax (Rabs a - h) 0.
Lemma clamp : forall a h, 0 <= h -> exists c, Rabs c <= h /\ Rabs (a - c) = beyond a h.
Proof.
  intros a h Hh. unfold beyond. destruct (Rle_dec (Rabs a) h).
  - exists a. split; auto. replace (a - a) with 0 by ring. rewrite Rabs_R0, Rmax_right; lra.
  - destruct (Rle_dec 0 a).
    + rewrite Rabs_pos_eq in * by lra. exists h. rewrite Rmax_left by lra. split; rewrite Rabs_pos_eq; lra.
    + rewrite Rabs_left in * by lra. exists (- h). rewrite Rmax_left by lra. split; rewrite Rabs_left1; lra.
Qed.
Lemma abs_sq : forall a, Rabs a * Rabs a = a * a.
Proof. intro a; unfold Rabs; destruct (Rcase_abs a); ring. Qed.
Lemma norm_of_abs : forall a b, Rabs (x a) = x b -> Rabs (y a) = y b -> Rabs (z a) = z b -> norm a = norm b.
Proof. intros a b Hx Hy Hz; unfold norm, dot; rewrite <- Hx, <- Hy, <- Hz, !abs_sq; reflexivity. Qed.

Theorem sphere_near : forall q, near sphere q (norm q).
Proof. intros [a b c]. exists O. split; [reflexivity|]. right; unfold sub, O; simpl; do 2 f_equal; ring. Qed.
Theorem box_near : forall q a b c, 0 <= a -> 0 <= b -> 0 <= c ->
  near (box a b c) q (norm (V (beyond (x q) a) (beyond (y q) b) (beyond (z q) c))).
Proof.
  intros q a b c Ha Hb Hc. destruct (clamp (x q) a Ha) as (cx & Hx & Ex), (clamp (y q) b Hb) as (cy & Hy & Ey), (clamp (z q) c Hc) as (cz & Hz & Ez).
  exists (V cx cy cz). split; [unfold box; simpl; auto|]. right; apply norm_of_abs; simpl; auto.
Qed.
Theorem capsule_near : forall q h, 0 <= h -> near (capsule h) q (norm (V (x q) (y q) (beyond (z q) h))).
Proof.
  intros q h Hh. destruct (clamp (z q) h Hh) as (c & Hc & Ec). exists (V 0 0 c). split; [unfold capsule; simpl; auto|].
  right; unfold norm, dot; simpl. f_equal. rewrite <- Ec, abs_sq. ring.
Qed.
(* The disc of radius r in the plane: q kept, or drawn in. *)
Lemma disc : forall a b r, 0 <= r -> exists c d, norm (flat c d) <= r /\ norm (flat (a - c) (b - d)) = Rmax (norm (flat a b) - r) 0.
Proof.
  intros a b r Hr. set (rho := norm (flat a b)). destruct (Rle_dec rho r).
  - exists a, b. split; auto. rewrite Rmax_right by lra. unfold norm, flat, dot; simpl.
    replace ((a-a)*(a-a)+(b-b)*(b-b)+0*0) with 0 by ring. apply sqrt_0.
  - assert (0 < rho) by lra. exists (r / rho * a), (r / rho * b).
    assert (0 <= r / rho <= 1).
    { split; [apply Rmult_le_pos; [lra | left; now apply Rinv_0_lt_compat]|]. apply Rmult_le_reg_l with rho; auto. replace (rho * (r / rho)) with r by (field; lra). lra. }
    split.
    + replace (flat (r / rho * a) (r / rho * b)) with (mul (r / rho) (flat a b)) by (unfold mul, flat; simpl; f_equal; ring).
      rewrite norm_mul, Rabs_pos_eq by lra. fold rho. right; field; lra.
    + replace (flat (a - r / rho * a) (b - r / rho * b)) with (mul (1 - r / rho) (flat a b)) by (unfold mul, flat; simpl; f_equal; ring).
      rewrite norm_mul, Rabs_pos_eq by lra. fold rho. rewrite Rmax_left by lra. field; lra.
Qed.
Lemma flat_sq : forall a b, norm (flat a b) * norm (flat a b) = a * a + b * b.
Proof. intros; rewrite norm_sq; unfold dot, flat; simpl; ring. Qed.
Theorem cylinder_near : forall q r h, 0 <= r -> 0 <= h -> near (cylinder r h) q (norm (V (Rmax (across q - r) 0) 0 (beyond (z q) h))).
Proof.
  intros q r h Hr Hh. destruct (disc (x q) (y q) r Hr) as (c & d & Hcd & Ed), (clamp (z q) h Hh) as (e & He & Ez).
  exists (V c d e). split; [unfold cylinder, across; simpl; auto|]. right; unfold norm, dot; simpl. f_equal.
  unfold across. rewrite <- Ed, <- Ez, abs_sq, flat_sq. ring.
Qed.
Theorem cone_near : forall q r h s, 0 <= r -> 0 <= s <= 1 ->
  near (cone r h) q (norm (V (Rmax (across q - s * r) 0) 0 (z q - h * (1 - 2 * s)))).
Proof.
  intros q r h s Hr Hs. destruct (disc (x q) (y q) (s * r)) as (c & d & Hcd & Ed); [nra|].
  exists (V c d (h * (1 - 2 * s))). split; [exists s; unfold across; simpl; auto|]. right; unfold norm, dot; simpl. f_equal.
  unfold across. rewrite <- Ed, flat_sq. ring.
Qed.
(* u may be longer than 1 by as much as rounding made it. *)
Theorem ellipsoid_near : forall q h u e, 0 <= e -> norm u <= 1 + e -> 0 <= x h <= 1 -> 0 <= y h <= 1 -> 0 <= z h <= 1 ->
  near (ellipsoid h) q (norm (sub q (stretch h u)) + e).
Proof.
  intros q h u e He Hu Hx Hy Hz. set (k := / (1 + e)). assert (0 < k) by (apply Rinv_0_lt_compat; lra).
  assert (Hk : k * (1 + e) = 1) by (unfold k; field; lra).
  exists (stretch h (mul k u)). split.
  - exists (mul k u). split; auto. rewrite norm_mul, Rabs_pos_eq by lra. nra.
  - pose proof (triangle_sub q (stretch h u) (stretch h (mul k u))).
    enough (norm (sub (stretch h u) (stretch h (mul k u))) <= e) by lra.
    replace (sub (stretch h u) (stretch h (mul k u))) with (mul (1 - k) (stretch h u)) by (unfold sub, mul, stretch; simpl; f_equal; ring).
    rewrite norm_mul, Rabs_pos_eq by nra.
    assert (norm (stretch h u) <= norm u).
    { apply norm_le; [apply norm_pos|]. rewrite norm_sq. destruct u as [a b c], h as [ha hb hc]; unfold dot, stretch; simpl in *.
      assert (ha*a*(ha*a) <= a*a) by (replace (ha*a*(ha*a)) with (ha*ha*(a*a)) by ring; assert (0 <= a*a) by nra; assert (ha*ha <= 1) by nra; nra).
      assert (hb*b*(hb*b) <= b*b) by (replace (hb*b*(hb*b)) with (hb*hb*(b*b)) by ring; assert (0 <= b*b) by nra; assert (hb*hb <= 1) by nra; nra).
      assert (hc*c*(hc*c) <= c*c) by (replace (hc*c*(hc*c)) with (hc*hc*(c*c)) by ring; assert (0 <= c*c) by nra; assert (hc*hc <= 1) by nra; nra). lra. }
    pose proof (norm_pos (stretch h u)). assert (0 <= 1 - k) by nra. nra.
Qed.
Theorem halfspace_near : forall q, near halfspace q (Rmax (z q) 0).
Proof.
  intros [a b c]; simpl. destruct (Rle_dec c 0).
  - exists (V a b c). split; [exact r|]. rewrite Rmax_right by lra. right; unfold norm, dot, sub; simpl.
    replace ((a-a)*(a-a)+(b-b)*(b-b)+(c-c)*(c-c)) with 0 by ring. apply sqrt_0.
  - exists (V a b 0). split; [unfold halfspace; simpl; lra|]. rewrite Rmax_left by lra. apply norm_le; [lra|].
    unfold dot, sub; simpl. nra.
Qed.
(* Weights that are not negative and add up to W > 0 make a point of the hull. *)
Fixpoint total (l : list (R * vec)) := match l with [] => 0 | (w, _) :: l => w + total l end.
Fixpoint weighed (l : list (R * vec)) := match l with [] => O | (w, p) :: l => add (mul w p) (weighed l) end.
Theorem weights_in_hull : forall ps l, (forall w p, In (w, p) l -> 0 <= w /\ In p ps) -> 0 < total l -> hull ps (mul (/ total l) (weighed l)).
Proof.
  intros ps l. induction l as [|[w p] l IH]; intros H HT; simpl in *; [lra|].
  destruct (H w p (or_introl eq_refl)) as [Hw Hp].
  assert (Hl : forall w p, In (w, p) l -> 0 <= w /\ In p ps) by (intros; apply H; auto).
  assert (T0 : 0 <= total l).
  { clear - Hl. induction l as [|[v q] l IH]; simpl; [lra|]. destruct (Hl v q (or_introl eq_refl)).
    enough (0 <= total l) by lra. apply IH. intros; apply Hl; now right. }
  destruct (Rle_lt_or_eq_dec _ _ T0) as [TP | TZ].
  - specialize (IH Hl TP). set (T := total l) in *. set (s := weighed l) in *.
    replace (mul (/ (w + T)) (add (mul w p) s)) with (add (mul (1 - T / (w + T)) p) (mul (T / (w + T)) (mul (/ T) s))).
    + apply between; auto; [|now apply corner]. split.
      * apply Rmult_le_pos; [lra | left; apply Rinv_0_lt_compat; lra].
      * apply Rmult_le_reg_l with (w + T); [lra|]. replace ((w + T) * (T / (w + T))) with T by (field; lra). lra.
    + destruct p, s; unfold add, mul; simpl; f_equal; field; lra.
  - assert (Z : weighed l = O \/ exists v q, In (v, q) l /\ v <> 0).
    { clear - l. induction l as [|[v q] l IH]; [now left|]. destruct (Req_dec v 0) as [-> | Hv]; [|right; exists v, q; simpl; auto].
      destruct IH as [E | (v & r & Hin & Hv)]; [left | right; exists v, r; simpl; auto].
      simpl; rewrite E; destruct q; unfold add, mul, O; simpl; f_equal; ring. }
    destruct Z as [-> | (v & q & Hin & Hv)].
    + rewrite <- TZ. replace (mul (/ (w + 0)) (add (mul w p) O)) with p; [now apply corner|].
      destruct p; unfold add, mul, O; simpl; f_equal; field; lra.
    + exfalso. assert (G : forall l, (forall w p, In (w, p) l -> 0 <= w /\ In p ps) -> In (v, q) l -> v <= total l).
      { clear - l. intro k; induction k as [|[a b] k IH]; simpl; [tauto|]. intros Hk [E | E].
        - inversion E; subst. enough (0 <= total k) by lra. clear - Hk. induction k as [|[c d] k IH]; simpl; [lra|].
          destruct (Hk c d (or_intror (or_introl eq_refl))). enough (0 <= total k) by lra. apply IH. intros w p [E|E]; apply Hk; simpl; auto.
        - destruct (Hk a b (or_introl eq_refl)). specialize (IH (fun w p i => Hk w p (or_intror i)) E). lra. }
      specialize (G l Hl Hin). destruct (Hl v q Hin). lra.
Qed.

(* ---- convexity ---- *)

Theorem rounded_convex : forall S r, convex S -> convex (rounded S r).
Proof.
  intros S r HS p q t Ht (c & Hc & Ec) (d & Hd & Ed). exists (add (mul (1 - t) c) (mul t d)). split; [now apply HS|].
  replace (sub (add (mul (1 - t) p) (mul t q)) (add (mul (1 - t) c) (mul t d))) with (add (mul (1 - t) (sub p c)) (mul t (sub q d)))
    by (unfold sub, add, mul; simpl; f_equal; ring).
  pose proof (triangle (mul (1 - t) (sub p c)) (mul t (sub q d))). rewrite !norm_mul, !Rabs_pos_eq in H by lra. nra.
Qed.
Lemma abs_convex : forall a b h t, 0 <= t <= 1 -> Rabs a <= h -> Rabs b <= h -> Rabs ((1 - t) * a + t * b) <= h.
Proof. intros a b h t Ht Ha Hb. apply Rabs_le. revert Ha Hb; unfold Rabs; destruct (Rcase_abs a), (Rcase_abs b); intros; split; nra. Qed.
Lemma across_convex : forall p q r s t, 0 <= t <= 1 -> across p <= r -> across q <= s -> across (add (mul (1 - t) p) (mul t q)) <= (1 - t) * r + t * s.
Proof.
  intros p q r s t Ht Hp Hq. unfold across.
  replace (flat (x (add (mul (1 - t) p) (mul t q))) (y (add (mul (1 - t) p) (mul t q)))) with (add (mul (1 - t) (flat (x p) (y p))) (mul t (flat (x q) (y q))))
    by (unfold add, mul, flat; simpl; f_equal; ring).
  pose proof (triangle (mul (1 - t) (flat (x p) (y p))) (mul t (flat (x q) (y q)))). rewrite !norm_mul, !Rabs_pos_eq in H by lra. unfold across in *. nra.
Qed.
Theorem box_convex : forall a b c, convex (box a b c).
Proof. intros a b c p q t Ht (A & B & C) (D & E & F). repeat split; simpl; apply abs_convex; auto. Qed.
Theorem capsule_convex : forall h, convex (capsule h).
Proof. intros h p q t Ht (A & B & C) (D & E & F). repeat split; simpl; [rewrite A, D; ring | rewrite B, E; ring | apply abs_convex; auto]. Qed.
Theorem cylinder_convex : forall r h, convex (cylinder r h).
Proof.
  intros r h p q t Ht (A & B) (C & D). split; [|simpl; apply abs_convex; auto].
  pose proof (across_convex p q r r t Ht A C). lra.
Qed.
Theorem cone_convex : forall r h, convex (cone r h).
Proof.
  intros r h p q t Ht (s & Hs & A & B) (s' & Hs' & C & D). exists ((1 - t) * s + t * s'). repeat split; [nra | nra | |].
  - pose proof (across_convex p q _ _ t Ht A C). lra.
  - simpl; rewrite B, D; ring.
Qed.
Theorem ellipsoid_convex : forall h, convex (ellipsoid h).
Proof.
  intros h p q t Ht (u & Hu & ->) (v & Hv & ->). exists (add (mul (1 - t) u) (mul t v)). split.
  - pose proof (triangle (mul (1 - t) u) (mul t v)). rewrite !norm_mul, !Rabs_pos_eq in H by lra. nra.
  - unfold add, mul, stretch; simpl; f_equal; ring.
Qed.
Theorem halfspace_convex : convex halfspace.
Proof. intros p q t Ht A B; unfold halfspace, add, mul in *; simpl in *; nra. Qed.
Theorem hull_convex : forall ps, convex (hull ps).
Proof. intros ps p q t Ht A B; now apply between. Qed.

(* ---- motions and features ---- *)

(* Between two looks, by the speed. g is the distance of any two points of A and B. *)
Theorem speed_keeps_apart : forall (g : R -> R) t0 t1 l0 l1 speed margin, 0 <= speed -> t0 <= t1 ->
  (forall s t, t0 <= s <= t1 -> t0 <= t <= t1 -> Rabs (g s - g t) <= speed * Rabs (s - t)) ->
  l0 <= g t0 -> l1 <= g t1 -> 2 * margin + speed * (t1 - t0) < l0 + l1 -> forall t, t0 <= t <= t1 -> margin < g t.
Proof.
  intros g t0 t1 l0 l1 v m Hv H01 HL H0 H1 H t Ht.
  pose proof (HL t t0 Ht ltac:(lra)) as A. pose proof (HL t t1 Ht ltac:(lra)) as B.
  rewrite (Rabs_pos_eq (t - t0)) in A by lra. rewrite (Rabs_left1 (t - t1)) in B by lra.
  revert A B; unfold Rabs; destruct (Rcase_abs (g t - g t0)), (Rcase_abs (g t - g t1)); intros; nra.
Qed.
(* By the bend: f is n . (b - a) of any two points, along a fixed axis. *)
Theorem bend_keeps_apart : forall (f v : R -> R) t0 t1 l bend, t0 < t1 -> 0 <= bend ->
  (forall t, t0 <= t <= t1 -> derivable_pt_lim f t (v t)) ->
  (forall s t, t0 <= s <= t -> t <= t1 -> v t - v s <= bend * (t - s)) ->
  l <= f t0 -> l <= f t1 -> forall t, t0 <= t <= t1 -> l - bend * (t1 - t0) ^ 2 / 8 <= f t.
Proof.
  intros f v t0 t1 l bend H01 Hb HD HL H0 H1 t Ht.
  set (g := fun s => f s + bend / 2 * ((s - t0) * (t1 - s))).
  assert (Dg : forall s, t0 <= s <= t1 -> derivable_pt_lim g s (v s + bend / 2 * (t0 + t1 - 2 * s))).
  { intros s Hs. unfold g. apply derivable_pt_lim_plus; [now apply HD|].
    apply derivable_pt_lim_scal with (f := fun s => (s - t0) * (t1 - s)).
    replace (t0 + t1 - 2 * s) with ((1 - 0) * (t1 - s) + (s - t0) * (0 - 1)) by ring.
    apply derivable_pt_lim_mult with (f1 := fun s => s - t0) (f2 := fun s => t1 - s);
      apply derivable_pt_lim_minus; (apply derivable_pt_lim_id || apply derivable_pt_lim_const). }
  assert (M : forall a b, t0 <= a -> a < b -> b <= t1 -> exists c, g b - g a = (v c + bend / 2 * (t0 + t1 - 2 * c)) * (b - a) /\ a < c < b).
  { intros a b Ha Hab Hb'. apply MVT_cor2; auto. intros c Hc. apply Dg. lra. }
  assert (G : l <= g t).
  { destruct (Req_dec t t0) as [-> | N0]; [unfold g; replace (t0 - t0) with 0 by ring; lra|].
    destruct (Req_dec t t1) as [-> | N1]; [unfold g; replace (t1 - t1) with 0 by ring; lra|].
    destruct (M t0 t ltac:(lra) ltac:(lra) ltac:(lra)) as (c & Ec & Hc), (M t t1 ltac:(lra) ltac:(lra) ltac:(lra)) as (d & Ed & Hd).
    assert (E0 : g t0 = f t0) by (unfold g; ring). assert (E1 : g t1 = f t1) by (unfold g; ring).
    destruct (Rle_dec l (g t)); auto. exfalso. pose proof (HL c d ltac:(lra) ltac:(lra)).
    set (gc := v c + bend / 2 * (t0 + t1 - 2 * c)) in *. set (gd := v d + bend / 2 * (t0 + t1 - 2 * d)) in *.
    assert (gd <= gc) by (unfold gc, gd; lra).
    assert (gc * (t - t0) < 0) by lra. assert (gd * (t1 - t) > 0) by lra.
    assert (gc < 0) by nra. assert (gd > 0) by nra. lra. }
  assert ((t - t0) * (t1 - t) <= (t1 - t0) ^ 2 / 4) by (pose proof (Rle_0_sqr (t - t0 - (t1 - t))); unfold Rsqr in *; nra).
  unfold g in G. nra.
Qed.
(* Features: the product with each corner is linear in time; what is between corners has no less. *)
Theorem linear_between : forall a b l t t0 t1, t0 <= t <= t1 -> l < (1 - t0) * a + t0 * b -> l < (1 - t1) * a + t1 * b -> l < (1 - t) * a + t * b.
Proof.
  intros a b l t t0 t1 Ht H0 H1. destruct (Rle_dec 0 (b - a)).
  - replace ((1 - t) * a + t * b) with ((1 - t0) * a + t0 * b + (t - t0) * (b - a)) by ring. nra.
  - replace ((1 - t) * a + t * b) with ((1 - t1) * a + t1 * b + (t1 - t) * - (b - a)) by ring. nra.
Qed.
Theorem direction_parts : forall (P : list vec) d s, 0 <= s -> (forall w, In w P -> s * norm d < dot d w) -> forall p, hull P p -> s < norm p.
Proof.
  intros P d s Hs H p Hp. assert (s * norm d < dot d p).
  { induction Hp; [auto|]. rewrite dot_add, !dot_mul. destruct (Req_dec t 0) as [-> | N]; [lra|]. destruct (Req_dec t 1) as [-> | N1]; [lra|]. nra. }
  pose proof (cauchy_schwarz d p). pose proof (norm_pos d). pose proof (norm_pos p).
  destruct (Rle_dec (norm p) s); [|lra]. exfalso. nra.
Qed.
