(* What alpha and beta mean: half-planes, strips, disks, sectors by name. *)
From Coq Require Import ZArith QArith.
From mathcomp Require Import all_ssreflect all_algebra ssrZ zify ring.
From formal Require Export numbers.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Unset Implicit Arguments.
Definition in_half_plane (sigma : Q) : place := fun C s => 'Re s < - phiQ C sigma.
Definition in_strip (left right : Q) : place := fun C s =>
  phiQ C left < 'Re s < phiQ C right.
Definition in_horizontal_strip (omega : Q) : place := fun C s => `|'Im s| < phiQ C omega.
Definition in_disk (rho centre : Q) : place := fun C s => `|s - phiQ C centre| < phiQ C rho.
(* The half-angle is that whose tangent is sine / cosine. *)
Definition in_sector (sine cosine apex : Q) : place := fun C s =>
  'Re s < phiQ C apex /\ `|'Im s| * phiQ C cosine < (phiQ C apex - 'Re s) * phiQ C sine.

Set Implicit Arguments.

(* What numbers of a file belong to them; they may be rounded inwards. *)
Definition entry (a : numbers) i j : Q := nth (Qmake Z0 xH) (nth [::] a i) j.
Definition same (a : numbers) (b : seq (seq Q)) n := all (fun i => all (fun j =>
  Qeq_bool (entry a i j) (entry b i j)) (iota 0 n)) (iota 0 n).
Definition zero : Q := Qmake Z0 xH. Definition one : Q := Qmake (Zpos xH) xH.
Definition two : Q := Qmake (Zpos 2) xH.
Definition half_plane_fits sigma alpha beta :=
  same beta [:: [:: one]] 1 && Qle_bool (Qmult two sigma) (entry alpha 0 0).

Definition strip_fits left right alpha beta :=
  [&& same beta [:: [:: Qopp one; zero]; [:: zero; one]] 2,
      Qeq_bool (entry alpha 0 1) (entry alpha 1 0),
      Qle_bool (Qmult two left) (entry alpha 0 0)
    & Qle_bool (Qopp (Qmult two right)) (entry alpha 1 1)].
Definition horizontal_strip_fits omega alpha beta :=
  [&& same beta [:: [:: zero; one]; [:: Qopp one; zero]] 2,
      Qeq_bool (entry alpha 0 1) (entry alpha 1 0), Qle_bool zero omega,
      Qle_bool (Qopp (Qmult two omega)) (entry alpha 0 0)
    & Qle_bool (Qopp (Qmult two omega)) (entry alpha 1 1)].
Definition disk_fits rho centre alpha beta :=
  same beta [:: [:: zero; one]; [:: zero; zero]] 2 && Qle_bool zero rho
  && same alpha [:: [:: Qopp rho; Qopp centre]; [:: Qopp centre; Qopp rho]] 2.
Definition sector_fits sine cosine apex alpha beta :=
  [&& same beta [:: [:: sine; cosine]; [:: Qopp cosine; sine]] 2,
      Qeq_bool (entry alpha 0 1) zero, Qeq_bool (entry alpha 1 0) zero,
      Qeq_bool (entry alpha 0 0) (entry alpha 1 1), Qle_bool zero cosine,
      Qle_bool sine zero == false
    & Qle_bool (Qopp (Qmult two (Qmult sine apex))) (entry alpha 0 0)].

Section Meaning.
Variable C : numClosedFieldType.
Notation q := (phiQ C).

Lemma phiQ_le a b : Qle_bool a b -> q a <= q b.
Proof.
rewrite /Qle_bool => h; rewrite /phiQ ler_pdivr_mulr ?phi_gt0 //.
rewrite mulrAC ler_pdivl_mulr ?phi_gt0 // -!phiM -subr_ge0 -phiB; apply: phi_ge0; lia.
Qed.
Lemma phiQ_eq a b : Qeq_bool a b -> q a = q b.
Proof.
move=> /Qeq_bool_iff e; apply/eqP; rewrite eq_le.
by rewrite !phiQ_le //; apply/Qle_bool_iff; rewrite e; exact: Qle_refl.
Qed.
Lemma phiQ_lt a b : ~~ Qle_bool b a -> q a < q b.
Proof.
rewrite /Qle_bool => h; rewrite /phiQ ltr_pdivr_mulr ?phi_gt0 //.
rewrite mulrAC ltr_pdivl_mulr ?phi_gt0 // -!phiM -subr_gt0 -phiB; apply: phi_gt0; lia.
Qed.
Lemma phiQM a b : q (Qmult a b) = q a * q b.
Proof. by rewrite /phiQ /= (phiM C (Zpos _) (Zpos _)) phiM invfM mulrACA. Qed.
Lemma phiQN a : q (Qopp a) = - q a.
Proof. by rewrite /phiQ /= phiN mulNr. Qed.
Lemma phiQ0 : q zero = 0. Proof. by rewrite /phiQ phi0 mul0r. Qed.
Lemma phiQ1 : q one = 1. Proof. by rewrite /phiQ phi1 divr1. Qed.
Lemma phiQ2 : q two = 2%:R. Proof. by rewrite /phiQ phi1 divr1. Qed.
Lemma phiQ_real a : q a \is Num.real.
Proof. by rewrite /phiQ rpred_div // /phi realz. Qed.

Lemma same_entry a b n i j : same a b n -> (i < n)%N -> (j < n)%N ->
  q (entry a i j) = q (entry b i j).
Proof.
move=> /allP sa hi hj; apply: phiQ_eq.
by have /allP := sa i ltac:(by rewrite mem_iota); apply; rewrite mem_iota.
Qed.

Lemma twice_Re (s : C) : s + s^* = 2%:R * 'Re s.
Proof. by rewrite ReE mulrC divfK ?pnatr_eq0. Qed.
Lemma conj_rect (s : C) : s^* = 'Re s - 'i * 'Im s.
Proof. by rewrite [in LHS](Crect s) rmorphD rmorphM conjCi !conj_Creal ?Creal_Re ?Creal_Im // mulNr. Qed.

Lemma half_plane_sound sigma alpha beta (s : C) : half_plane_fits sigma alpha beta ->
  in_matrices 1 alpha beta C s -> in_half_plane sigma C s.
Proof.
move=> /andP[b1 /phiQ_le]; rewrite phiQM phiQ2 => le_a.
move=> /(_ 1%:M ltac:(by rewrite oner_neq0)).
rewrite /herm /sesqui mul1mx !mxE big_ord1 !mxE /= rmorph1 mulr1.
rewrite -/(entry alpha 0 0) -/(entry beta 0 0) (same_entry b1) //= phiQ1 !mulr1.
rewrite -addrA twice_Re => neg; rewrite /in_half_plane -subr_lt0 opprK.
rewrite -(pmulr_rlt0 _ (ltr0Sn C 1)) mulrDr; apply: le_lt_trans neg.
by rewrite addrC ler_add2r.
Qed.

(* Two rows: the diagonal is negative, and the determinant positive. *)
Lemma two_rows alpha beta (s : C) : in_matrices 2 alpha beta C s ->
  let a i j := q (entry alpha i j) in let b i j := q (entry beta i j) in
  let x := 'Re s in let y := 'Im s in
  let l := a 0%N 0%N + 2%:R * b 0%N 0%N * x in
  let r := a 1%N 1%N + 2%:R * b 1%N 1%N * x in
  a 0%N 1%N = a 1%N 0%N ->
  [/\ l < 0, r < 0 &
    (a 0%N 1%N + (b 0%N 1%N + b 1%N 0%N) * x) ^+ 2
    + ((b 0%N 1%N - b 1%N 0%N) * y) ^+ 2 < l * r].
Proof.
move=> inside a b x y l r a01.
set u := a 0%N 1%N + (b 0%N 1%N + b 1%N 0%N) * x; set v := (b 0%N 1%N - b 1%N 0%N) * y.
have neg (f g : C) : (f != 0) || (g != 0) ->
    l * (f * f^*) + r * (g * g^*) + (f * g^* * (u + 'i * v) + g * f^* * (u - 'i * v)) < 0.
  move=> nz; pose w : 'rV[C]_2 := \row_j (if j == 0 then f else g).
  have /inside : w != 0.
    apply/rV0Pn; case/orP: nz => h; [exists 0 | exists 1]; by rewrite mxE.
  rewrite /herm /sesqui !mxE !big_ord_recl !big_ord0 !mxE !big_ord_recl !big_ord0 !mxE /=.
  rewrite -/(entry alpha 0 0) -/(entry beta 0 0) -/(entry alpha 0 1) -/(entry beta 0 1).
  rewrite -/(entry alpha 1 0) -/(entry beta 1 0) -/(entry alpha 1 1) -/(entry beta 1 1).
  rewrite -/(a 0%N 0%N) -/(b 0%N 0%N) -/(a 0%N 1%N) -/(b 0%N 1%N).
  rewrite -/(a 1%N 0%N) -/(b 1%N 0%N) -/(a 1%N 1%N) -/(b 1%N 1%N) -a01.
  have e := Crect s; rewrite -/x -/y in e.
  congr (_ < 0); rewrite /l /r /u /v (conj_rect s) -/x -/y e; ring.
have l0 : l < 0.
  have := neg 1 0; rewrite oner_neq0 => /(_ isT); congr (_ < 0).
  by rewrite conjC0 conjC1; ring.
have r0 : r < 0.
  have := neg 0 1; rewrite oner_neq0 orbT => /(_ isT); congr (_ < 0).
  by rewrite conjC0 conjC1; ring.
split=> //; have real_l : l^* = l by rewrite conj_Creal // ltr0_real.
have uu : u^* = u.
  apply: conj_Creal; apply: realD; first exact: phiQ_real.
  by apply: realM; [apply: realD; exact: phiQ_real | exact: Creal_Re].
have vv : v^* = v.
  apply: conj_Creal; apply: realM; last exact: Creal_Im.
  by apply: realB; exact: phiQ_real.
have fc : (- (u - 'i * v))^* = - (u + 'i * v).
  by rewrite rmorphN rmorphB rmorphM conjCi uu vv mulNr opprK.
have := neg (- (u - 'i * v)) l; rewrite (lt_eqF l0) orbT fc real_l => /(_ isT).
have -> : l * (- (u - 'i * v) * - (u + 'i * v)) + r * (l * l)
    + (- (u - 'i * v) * l * (u + 'i * v) + l * - (u + 'i * v) * (u - 'i * v))
  = l * (l * r - (u ^+ 2 - 'i ^+ 2 * v ^+ 2)) by ring.
by rewrite sqrCi mulN1r opprK nmulr_rlt0 // subr_gt0.
Qed.

Lemma strip_sound left right alpha beta (s : C) : strip_fits left right alpha beta ->
  in_matrices 2 alpha beta C s -> in_strip left right C s.
Proof.
move=> /and4P[b2 /phiQ_eq a01 /phiQ_le l0 /phiQ_le r0] /two_rows two.
have {two}[] := two a01.
move: l0 r0; rewrite !phiQN !phiQM phiQ2 !(same_entry b2) //= !phiQN phiQ1.
rewrite mulrN1 mulr1 mulNr => l0 r0; rewrite subr_lt0 => l1 r1 _.
apply/andP; split; rewrite -(ltr_pmul2l (ltr0Sn C 1)).
  exact: le_lt_trans l0 l1.
by rewrite -subr_lt0; apply: le_lt_trans r1; rewrite addrC ler_add2r.
Qed.

Lemma square_less (a b : C) : a \is Num.real -> 0 <= b -> a ^+ 2 < b ^+ 2 -> `|a| < b.
Proof.
by move=> ra b0; rewrite -(real_normK ra) ltr_pexpn2r // nnegrE.
Qed.

Lemma sq_ge0 (a : C) : a \is Num.real -> 0 <= a ^+ 2.
Proof. by move=> ra; rewrite -(real_normK ra) exprn_ge0. Qed.
Lemma bounded (l r m : C) : l < 0 -> r < 0 -> - m <= l -> - m <= r -> l * r <= m ^+ 2.
Proof.
move=> l0 r0 l1 r1; rewrite -mulrNN expr2; apply: ler_pmul; rewrite ?oppr_ge0.
- exact: ltW.
- exact: ltW.
- by rewrite ler_oppl.
- by rewrite ler_oppl.
Qed.

Lemma horizontal_strip_sound omega alpha beta (s : C) :
  horizontal_strip_fits omega alpha beta -> in_matrices 2 alpha beta C s ->
  in_horizontal_strip omega C s.
Proof.
move=> /and5P[b2 /phiQ_eq a01 /phiQ_le w0 /phiQ_le l0 /phiQ_le r0] /two_rows two.
have {two}[] := two a01; move: w0 l0 r0; rewrite !phiQN phiQM phiQ2 phiQ0.
rewrite !(same_entry b2) //= phiQN phiQ1 phiQ0 !mulr0 !mul0r !addr0 subrr mul0r addr0.
rewrite opprK => w0 l0 r0 l1 r1 det; rewrite /in_horizontal_strip.
rewrite -(ltr_pmul2l (ltr0Sn C 1)) -[X in X * `|_|]normr_nat -normrM.
apply: square_less; [| exact: mulr_ge0 | apply: lt_le_trans (bounded l1 r1 l0 r0)].
  by apply: realM; [exact: realn | exact: Creal_Im].
by apply: le_lt_trans det; rewrite -mulr2n ler_addr sq_ge0 // phiQ_real.
Qed.

Lemma disk_sound rho centre alpha beta (s : C) : disk_fits rho centre alpha beta ->
  in_matrices 2 alpha beta C s -> in_disk rho centre C s.
Proof.
move=> /andP[/andP[b2 /phiQ_le]]; rewrite phiQ0 => r0 a2 /two_rows two.
have {two}[] := two (eq_trans (same_entry a2 (ltn0Sn 1) (ltnSn 1))
  (esym (same_entry a2 (ltnSn 1) (ltn0Sn 1)))).
rewrite !(same_entry b2) // !(same_entry a2) //= !phiQN phiQ1 phiQ0.
rewrite !mulr0 !mul0r !addr0 subr0 !mul1r mulrNN -expr2 => _ _ det.
have c_real := phiQ_real centre.
rewrite /in_disk -(ltr_pexpn2r (ltn0Sn 1)) ?nnegrE // normC2_Re_Im.
rewrite !raddfB /= (Creal_ReP _ c_real) (Creal_ImP _ c_real) subr0.
by rewrite [_ - q centre]addrC.
Qed.

Lemma sector_sound sine cosine apex alpha beta (s : C) :
  sector_fits sine cosine apex alpha beta -> in_matrices 2 alpha beta C s ->
  in_sector sine cosine apex C s.
Proof.
move=> /and5P[b2 /phiQ_eq a0 /phiQ_eq a1 /phiQ_eq a2 /and3P[/phiQ_le c0 sine0 /phiQ_le l0]].
move=> /two_rows two; have {two}[] := two (eq_trans a0 (esym a1)).
have b00 : q (entry beta 0 0) = q sine.
  exact: (same_entry (i := 0) (j := 0) b2).
have b01 : q (entry beta 0 1) = q cosine.
  exact: (same_entry (i := 0) (j := 1) b2).
have b10 : q (entry beta 1 0) = q (Qopp cosine).
  exact: (same_entry (i := 1) (j := 0) b2).
have b11 : q (entry beta 1 1) = q sine.
  exact: (same_entry (i := 1) (j := 1) b2).
rewrite -a2 b00 b01 b10 b11 a0 phiQN phiQ0 opprK subrr mul0r addr0 expr0n add0r.
move: c0 l0; rewrite phiQN !phiQM phiQ2 phiQ0; set l := q (entry alpha 0 0) + _ => c0 l0.
move=> neg _ det; have s0 : 0 < q sine by rewrite -phiQ0 phiQ_lt // (eqP sine0).
have le : - l <= 2%:R * ((q apex - 'Re s) * q sine).
  have e : - (2%:R * ((q apex - 'Re s) * q sine))
      = - (2%:R * (q sine * q apex)) + 2%:R * q sine * 'Re s by ring.
  by rewrite ler_oppl e /l ler_add2r.
have pos : 0 < - l by rewrite oppr_gt0.
split.
  have := lt_le_trans pos le; rewrite pmulr_rgt0 ?ltr0Sn // pmulr_lgt0 // subr_gt0.
  exact.
rewrite -(ltr_pmul2l (ltr0Sn C 1)); apply: lt_le_trans le.
have -> : 2%:R * (`|'Im s| * q cosine) = `|(q cosine + q cosine) * 'Im s|.
  rewrite normrM [`|_ + _|]ger0_norm ?addr_ge0 //; ring.
apply: square_less; [| exact: ltW | by rewrite sqrrN [l ^+ 2]expr2].
by apply: realM; [apply: realD; exact: phiQ_real | exact: Creal_Im].
Qed.
End Meaning.
